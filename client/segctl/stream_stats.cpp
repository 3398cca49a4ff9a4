// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/stream_stats.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "fmt/format.h"
#include "nlohmann/json.hpp"

namespace segserve::segctl {
namespace {

double milliseconds(StreamStats::Clock::duration time) {
  return std::chrono::duration<double, std::milli>(time).count();
}

std::string number_or_dash(const std::optional<double>& value) { return value ? fmt::format("{:.1f}", *value) : "-"; }

}  // namespace

void StreamStats::add_frame(Clock::duration delay) {
  ++frames_;
  if (delay > kPunctual) ++late_;
  longest_delay_ = std::max(longest_delay_, delay);
}

void StreamStats::add(const client::Outcome& outcome, Time now) {
  switch (outcome.kind) {
    case client::OutcomeKind::kResult: {
      ++results_;
      if (outcome.result) segments_ = outcome.result->segmentation.segments;
      const auto latency = outcome.report.outcome_done - outcome.report.handed_over;
      done_.push_back({now, milliseconds(latency)});
      all_.add(done_.back().latency_ms);
      break;
    }
    case client::OutcomeKind::kDropped:
    case client::OutcomeKind::kExpired:
      ++dropped_;
      break;
    case client::OutcomeKind::kCancelled:
      break;
    default:
      ++failed_;
  }
  while (!done_.empty() && done_.front().at < now - kWindow) done_.pop_front();
}

double StreamStats::rate(Time now) const {
  const Time begin = window_begin(now);
  const double seconds = std::chrono::duration<double>(now - begin).count();
  const auto results = std::ranges::count_if(done_, [&](const Done& done) { return done.at >= begin; });
  return seconds > 0 ? static_cast<double>(results) / seconds : 0.0;
}

std::optional<double> StreamStats::latency_ms(double percent, Time now) const {
  std::vector<double> latencies;
  for (const Done& done : done_) {
    if (done.at >= window_begin(now)) latencies.push_back(done.latency_ms);
  }
  if (latencies.empty()) return std::nullopt;
  const auto rank =
      static_cast<std::ptrdiff_t>(std::clamp(std::ceil(percent / 100.0 * static_cast<double>(latencies.size())) - 1.0,
                                             0.0, static_cast<double>(latencies.size() - 1)));
  std::ranges::nth_element(latencies, latencies.begin() + rank);
  return latencies[static_cast<std::size_t>(rank)];
}

std::string StreamStats::table(Time now, std::size_t columns) const {
  const std::array<std::pair<const char*, std::string>, 7> cells{{{"frames", fmt::format("{}", frames_)},
                                                                  {"rate/s", fmt::format("{:.1f}", rate(now))},
                                                                  {"p50 ms", number_or_dash(latency_ms(50, now))},
                                                                  {"p95 ms", number_or_dash(latency_ms(95, now))},
                                                                  {"dropped", fmt::format("{}", dropped_)},
                                                                  {"failed", fmt::format("{}", failed_)},
                                                                  {"segments", fmt::format("{}", segments_)}}};
  std::string names;
  std::string figures;
  for (const auto& [name, figure] : cells) {
    constexpr std::size_t kLeast = 8;
    const std::size_t width = 1 + std::max({kLeast, std::string(name).size(), figure.size()});
    if (names.size() + width >= columns) break;
    names += fmt::format("{:>{}}", name, width);
    figures += fmt::format("{:>{}}", figure, width);
  }
  return names + "\n" + figures + "\n";
}

nlohmann::ordered_json StreamStats::json(Time now) const {
  const auto or_null = [](const std::optional<double>& value) {
    return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json();
  };
  return {{"frames", frames_},
          {"results", results_},
          {"dropped", dropped_},
          {"failed", failed_},
          {"late", late_},
          {"longest_delay_ms", milliseconds(longest_delay_)},
          {"seconds", std::chrono::duration<double>(now - start_).count()},
          {"rate", rate(now)},
          {"p50_ms", or_null(latency_ms(50, now))},
          {"p95_ms", or_null(latency_ms(95, now))},
          {"segments", segments_}};
}

std::string StreamStats::summary(Time end) const {
  const double seconds = std::chrono::duration<double>(end - start_).count();
  const double rate = seconds > 0 ? static_cast<double>(results_) / seconds : 0.0;
  std::string text = fmt::format("{} frames, {} results, {} dropped, {} failed in {:.1f} s: {:.1f} a second", frames_,
                                 results_, dropped_, failed_, seconds, rate);
  if (results_ > 0) text += fmt::format(", p50 {:.1f} ms, p95 {:.1f} ms", all_.percentile(50), all_.percentile(95));
  if (late_ > 0) {
    text += fmt::format("; the rate was not kept: {} frames were sent more than {} ms late, up to {:.0f} ms", late_,
                        kPunctual.count(), milliseconds(longest_delay_));
  }
  return text + "\n";
}

nlohmann::ordered_json StreamStats::summary_json(Time end) const {
  nlohmann::ordered_json json = this->json(end);
  const double seconds = json["seconds"];
  json["rate"] = seconds > 0 ? static_cast<double>(results_) / seconds : 0.0;
  json["p50_ms"] = results_ > 0 ? nlohmann::ordered_json(all_.percentile(50)) : nlohmann::ordered_json();
  json["p95_ms"] = results_ > 0 ? nlohmann::ordered_json(all_.percentile(95)) : nlohmann::ordered_json();
  return json;
}

}  // namespace segserve::segctl
