// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "client/load_test/load.hpp"

namespace segserve::bench {

/// Something that a reader must know to understand the figures of a run.
struct Finding {
  std::string code;  ///< for programs, e.g. "UNSTABLE"
  std::string text;  ///< a whole sentence
};

/// The findings that follow from the measurements alone: INTERRUPTED, UNFINISHED, FAILURES, UNSTABLE,
/// CLIENT_WAS_THE_LIMIT, LATE, TOO_FEW_SAMPLES.
std::vector<Finding> findings(const LoadOptions& options, const LoadResult& result);

/// Whether clearly fewer results came within the window than frames were due in it.
bool falls_behind(const Report& report);

/// The percentiles that are told.
inline constexpr std::array<std::pair<const char*, double>, 6> kPercentiles{
    {{"p50", 50}, {"p90", 90}, {"p95", 95}, {"p99", 99}, {"p99.9", 99.9}, {"p99.99", 99.99}}};

/// The names of the percentiles for which there are too few frames; none if there are no frames at all.
std::vector<std::string> too_few_for(const Latencies& latencies);

}  // namespace segserve::bench
