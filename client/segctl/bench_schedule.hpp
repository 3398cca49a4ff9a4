// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "client/load_test/arrivals.hpp"

// How the command line writes loads that change. Each function gives INVALID_ARGUMENT that says what is wrong.
namespace segserve::segctl {

/// A rate over time, and the parts of it that are reported on their own.
struct LoadSchedule {
  std::vector<bench::RateSegment> rates;
  std::vector<std::chrono::milliseconds> levels;
  std::vector<std::string> labels;  ///< of the levels

  std::chrono::milliseconds duration() const;
};

/// A time such as "500ms", "10s", "2m", "4h" or "10", which are seconds; from 100 ms to a day. `what` is what it
/// belongs to, for messages.
absl::StatusOr<std::chrono::milliseconds> parse_duration(std::string_view what, std::string_view text);

/// "10,20,40:10s": each of the rates for so long.
absl::StatusOr<LoadSchedule> parse_steps(std::string_view text);
/// "10:200:10s": the rate grows evenly from the first to the second within the time. It is reported in ten parts.
absl::StatusOr<LoadSchedule> parse_ramp(std::string_view text);

/// "8" is 8 clients; "1..32" are 1, 2, 4 and so on up to 32. From 1 to 1000.
absl::StatusOr<std::vector<std::size_t>> parse_clients(std::string_view text);

/// "5%" is 0.05; more than 0 and no more than 100 %.
absl::StatusOr<double> parse_share(std::string_view what, std::string_view text);

}  // namespace segserve::segctl
