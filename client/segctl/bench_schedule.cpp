// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/bench_schedule.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include "core/base/status_macros.hpp"
#include "fmt/format.h"

namespace segserve::segctl {
namespace {

constexpr double kLowestRate = 0.001, kHighestRate = 1e6;
constexpr std::size_t kMostSteps = 100;
constexpr std::size_t kMostClients = 1000;
constexpr std::int64_t kDayMs = 86'400'000;

/// The number at the begin of `text`, which it takes away; nullopt if there is none, or one that is not finite.
template <typename Number>
std::optional<Number> take_number(std::string_view& text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{}) return std::nullopt;
  if constexpr (std::is_floating_point_v<Number>) {
    if (!std::isfinite(number)) return std::nullopt;
  }
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return number;
}

template <typename Number>
std::optional<Number> whole_number(std::string_view text) {
  const auto number = take_number<Number>(text);
  return text.empty() ? number : std::nullopt;
}

std::optional<double> rate_of(std::string_view text) {
  const auto rate = whole_number<double>(text);
  return rate && *rate >= kLowestRate && *rate <= kHighestRate ? rate : std::nullopt;
}

absl::Status wrong(std::string_view flag, std::string_view text, std::string_view why) {
  return absl::InvalidArgumentError(fmt::format("{} {}: {}", flag, text, why));
}

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> words;
  for (std::size_t at = text.find(separator); at != std::string_view::npos; at = text.find(separator)) {
    words.push_back(text.substr(0, at));
    text.remove_prefix(at + 1);
  }
  words.push_back(text);
  return words;
}

double to_seconds(std::chrono::milliseconds time) { return static_cast<double>(time.count()) / 1000; }

}  // namespace

std::chrono::milliseconds LoadSchedule::duration() const {
  std::chrono::milliseconds sum(0);
  for (const auto level : levels) sum += level;
  return sum;
}

absl::StatusOr<std::chrono::milliseconds> parse_duration(std::string_view what, std::string_view text) {
  static constexpr std::pair<std::string_view, double> kUnits[] = {
      {"ms", 1}, {"s", 1e3}, {"", 1e3}, {"m", 60e3}, {"h", 3600e3}};
  std::string_view unit = text;
  const auto number = take_number<double>(unit);
  const auto* found = std::ranges::find(kUnits, unit, [](const auto& each) { return each.first; });
  if (!number || found == std::end(kUnits)) {
    return wrong(what, text, "it must be a time such as 500ms, 10s, 2m or 4h");
  }
  const double milliseconds = *number * found->second;
  if (!(milliseconds >= 100 && milliseconds <= kDayMs)) return wrong(what, text, "it is not from 100ms to 24h");
  return std::chrono::milliseconds(static_cast<std::int64_t>(milliseconds));
}

absl::StatusOr<LoadSchedule> parse_steps(std::string_view text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) return wrong("--steps", text, "it must be RATE,RATE,..:TIME, e.g. 10,20,40:10s");
  ASSIGN_OR_RETURN(const auto length, parse_duration("--steps", text.substr(colon + 1)));
  LoadSchedule schedule;
  for (const std::string_view word : split(text.substr(0, colon), ',')) {
    const auto rate = rate_of(word);
    if (!rate) return wrong("--steps", text, fmt::format("'{}' is no rate from 0.001 to 1000000", word));
    schedule.rates.push_back({*rate, *rate, to_seconds(length)});
    schedule.levels.push_back(length);
    schedule.labels.push_back(fmt::format("{:g} frames/s", *rate));
  }
  if (schedule.levels.size() > kMostSteps) return wrong("--steps", text, fmt::format("more than {} steps", kMostSteps));
  if (schedule.duration().count() > kDayMs) return wrong("--steps", text, "it takes more than a day");
  return schedule;
}

absl::StatusOr<LoadSchedule> parse_ramp(std::string_view text) {
  const auto words = split(text, ':');
  if (words.size() != 3) return wrong("--ramp", text, "it must be RATE:RATE:TIME, e.g. 10:200:10s");
  const auto from = rate_of(words[0]), to = rate_of(words[1]);
  for (const auto& [rate, word] : {std::pair(from, words[0]), std::pair(to, words[1])}) {
    if (!rate) return wrong("--ramp", text, fmt::format("'{}' is no rate from 0.001 to 1000000", word));
  }
  ASSIGN_OR_RETURN(const auto length, parse_duration("--ramp", words[2]));
  LoadSchedule schedule{.rates = {{*from, *to, to_seconds(length)}}, .levels = {}, .labels = {}};
  constexpr int kParts = 10;
  for (int i = 0; i < kParts; ++i) {
    schedule.levels.push_back(length * (i + 1) / kParts - length * i / kParts);
    const auto rate_at = [&](int part) { return *from + (*to - *from) * part / kParts; };
    schedule.labels.push_back(fmt::format("{:.4g} to {:.4g} frames/s", rate_at(i), rate_at(i + 1)));
  }
  return schedule;
}

absl::StatusOr<std::vector<std::size_t>> parse_clients(std::string_view text) {
  const std::size_t dots = text.find("..");
  const auto first = whole_number<std::size_t>(text.substr(0, dots));
  const auto last = dots == std::string_view::npos ? first : whole_number<std::size_t>(text.substr(dots + 2));
  if (!first || !last || *first < 1 || *last > kMostClients || *first > *last) {
    return absl::InvalidArgumentError(
        fmt::format("{} is neither a number from 1 to {} nor a range of them such as 1..32", text, kMostClients));
  }
  std::vector<std::size_t> counts;
  for (std::size_t count = *first; count < *last; count *= 2) counts.push_back(count);
  counts.push_back(*last);
  return counts;
}

absl::StatusOr<double> parse_share(std::string_view what, std::string_view text) {
  std::string_view unit = text;
  const auto percent = take_number<double>(unit);
  if (!percent || unit != "%" || *percent <= 0 || *percent > 100) {
    return wrong(what, text, "it must be a share such as 5%, above 0 and up to 100%");
  }
  return *percent / 100;
}

}  // namespace segserve::segctl
