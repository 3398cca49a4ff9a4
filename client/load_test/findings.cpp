// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/findings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string_view>

#include "fmt/format.h"
#include "fmt/ranges.h"

namespace segserve::bench {
namespace {

constexpr double kLateShare = 0.05;     // of frames, above which being late is worth a word
constexpr double kBusyShare = 0.8;      // of the CPUs or of a thread, above which there is no room left
constexpr double kMissingShare = 0.03;  // of the frames that were due, above which an open loop falls behind
constexpr double kMissingFrames = 3;    // that chance may move beyond the end of the window
constexpr double kGrowth = 1.3;         // of the latency between the first and the last third
constexpr double kSpread = 0.25;        // of the throughput of thirds, from their mean

double share(std::uint64_t part, std::uint64_t all) {
  return all == 0 ? 0 : static_cast<double>(part) / static_cast<double>(all);
}

/// A third of the measured window.
struct Third {
  double seconds = 0;
  std::uint64_t results = 0;
  double weighted_p50 = 0;  // over its intervals, by their results

  double rate() const { return seconds > 0 ? static_cast<double>(results) / seconds : 0; }
  double p50() const { return results > 0 ? weighted_p50 / static_cast<double>(results) : 0; }
};

/// Splits the window into thirds. Returns none if it is too short, or has too few results, for that.
std::optional<std::array<Third, 3>> thirds(const LoadResult& result) {
  std::vector<const TimelineEntry*> whole;
  for (const TimelineEntry& entry : result.timeline) {
    if (entry.t >= 0 && entry.t + entry.seconds <= result.window_s + 1e-3) whole.push_back(&entry);
  }
  constexpr std::size_t kFewestIntervals = 6;
  constexpr std::uint64_t kFewestResults = 30;
  if (whole.size() < kFewestIntervals) return std::nullopt;
  std::array<Third, 3> parts;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    Third& part = parts[i * parts.size() / whole.size()];
    part.seconds += whole[i]->seconds;
    part.results += whole[i]->results;
    const double p50 = whole[i]->p50_ms.value_or(0);
    if (std::isfinite(p50)) part.weighted_p50 += p50 * static_cast<double>(whole[i]->results);
  }
  if (std::ranges::all_of(parts, [](const Third& part) { return part.results < kFewestResults; })) return std::nullopt;
  return parts;
}

/// Whether the rate is meant to be the same over the whole window.
bool is_even(const LoadOptions& options) {
  if (options.replay_speed > 0) return false;
  return std::ranges::all_of(options.rates, [&](const RateSegment& segment) {
    return segment.from == options.rates.front().from && segment.to == segment.from;
  });
}

void add_stability(const LoadOptions& options, const LoadResult& result, std::vector<Finding>& all) {
  const Report& total = result.total;
  if (options.is_open() && falls_behind(total)) {
    all.push_back(
        {"UNSTABLE",
         fmt::format("The load was not carried: {:.1f} frames/s were due and {:.1f} got a result in "
                     "time, so that latencies grow with the length of the run.",
                     static_cast<double>(total.sent - total.dropped) / total.seconds, total.frames_per_second())});
    return;
  }
  const auto parts = thirds(result);
  if (!parts || !is_even(options)) return;
  const double first = parts->front().p50(), last = parts->back().p50();
  if (first > 0 && last > kGrowth * first) {
    all.push_back(
        {"UNSTABLE", fmt::format("The latency grew during the run: its median was {:.1f} ms in the first third "
                                 "and {:.1f} ms in the last.",
                                 first, last)});
    return;
  }
  const auto [least, most] = std::ranges::minmax(*parts, {}, [](const Third& part) { return part.rate(); });
  const double mean = total.frames_per_second();
  if (mean - least.rate() > kSpread * mean || most.rate() - mean > kSpread * mean) {
    all.push_back(
        {"UNSTABLE", fmt::format("The throughput was uneven: between {:.1f} and {:.1f} frames/s in the thirds of "
                                 "the run.",
                                 least.rate(), most.rate())});
  }
}

void add_limits_of_client(const LoadOptions& options, const LoadResult& result, std::vector<Finding>& all) {
  const Report& total = result.total;
  const double cpus = result.cpus;
  const double encoding =
      total.seconds > 0 ? total.encode_ms / 1000 / total.seconds / static_cast<double>(options.clients) : 0;
  if (cpus > 0 && result.busy_cpus() > kBusyShare * cpus) {
    all.push_back(
        {"CLIENT_WAS_THE_LIMIT", fmt::format("This process kept {:.1f} of its {:.0f} CPUs busy, so that it and not "
                                             "the server may have been the limit.",
                                             result.busy_cpus(), cpus)});
  } else if (encoding > kBusyShare) {
    all.push_back({"CLIENT_WAS_THE_LIMIT", fmt::format("Each client spent {:.0f} % of the time on encoding frames; "
                                                       "--encoded-beforehand does that before the run.",
                                                       100 * encoding)});
  }
  if (!options.is_open() || total.sent == 0) return;
  const auto not_sent = std::ranges::find_if(total.errors, [](const auto& each) { return each.first == "NOT_SENT"; });
  if (not_sent != total.errors.end()) {
    all.push_back(
        {"LATE", fmt::format("{} frames were due and could not be sent before the end: too many waited already.",
                             not_sent->second)});
  } else if (share(total.late, total.sent) > kLateShare) {
    all.push_back(
        {"LATE", fmt::format("{:.0f} % of the frames were sent more than 1 ms after they were due; their latency "
                             "counts from when they were due.",
                             100 * share(total.late, total.sent))});
  }
}

}  // namespace

bool falls_behind(const Report& report) {
  const auto due = static_cast<double>(report.sent - report.dropped);
  return due - static_cast<double>(report.finished) > kMissingShare * due + kMissingFrames;
}

std::vector<std::string> too_few_for(const Latencies& latencies) {
  std::vector<std::string> names;
  if (latencies.count() == 0) return names;
  for (const auto& [name, percent] : kPercentiles) {
    if (!latencies.bears(percent)) names.emplace_back(name);
  }
  return names;
}

std::vector<Finding> findings(const LoadOptions& options, const LoadResult& result) {
  std::vector<Finding> all;
  const Report& total = result.total;
  if (result.interrupted) {
    all.push_back(
        {"INTERRUPTED", fmt::format("The run was interrupted after {:.1f} s of its window of {:.1f} s; frames "
                                    "without an outcome then are not counted.",
                                    result.window_s, std::chrono::duration<double>(options.duration).count())});
  }
  if (total.failed() > 0) {
    all.push_back({"FAILURES",
                   fmt::format("{} of {} frames failed; they count as infinitely late.", total.failed(), total.sent)});
  }
  const auto unfinished = total.errors.find("UNFINISHED");
  if (unfinished != total.errors.end()) {
    all.push_back({"UNFINISHED", fmt::format("{} frames had no outcome {:.1f} s after the last one was sent.",
                                             unfinished->second, result.drain_s)});
  }
  add_stability(options, result, all);
  add_limits_of_client(options, result, all);
  if (const auto names = too_few_for(total.latency); !names.empty()) {
    all.push_back({"TOO_FEW_SAMPLES",
                   fmt::format("{} frames are too few for {}.", total.latency.count(), fmt::join(names, ", "))});
  }
  return all;
}

}  // namespace segserve::bench
