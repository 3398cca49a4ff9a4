// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "nlohmann/json_fwd.hpp"

namespace segserve::bench_report {

struct DiffOptions {
  double allow = 0.1;        ///< how much worse a figure may be, as a share of that of the first load test
  double confidence = 0.99;  ///< of the intervals
  std::uint64_t seed = 1;    ///< of the bootstrap
};

enum class DiffVerdict {
  kSame,     ///< the change is within what is allowed, and so is its interval
  kBetter,   ///< better by more than what is allowed, and the interval excludes no change
  kWorse,    ///< the same for worse
  kUnclear,  ///< the interval is too wide, or the frames are too few, to say
};

const char* name(DiffVerdict verdict);

/// How one figure changed from load test a to b.
struct DiffRow {
  std::string name, unit;
  double a = 0, b = 0;  ///< may be infinite
  /// (b - a) / a, or for `is_share` b - a in percentage points. Infinite if a frame of b fails where that of a had a
  /// result.
  double change = 0;
  bool is_share = false;
  std::optional<double> low = {}, high = {};  ///< of the change, with the confidence that was asked for
  const char* method = "";                    ///< what the interval is from, for people; "none" without one
  DiffVerdict verdict = DiffVerdict::kSame;
};

struct RunDiff {
  DiffOptions options;
  std::vector<DiffRow> rows;
  std::vector<std::string> caveats;
};

/// Compares two load tests that check_run accepts and that may be compared (reasons_not_to_compare). Figures that one
/// of them lacks have no row.
RunDiff diff_runs(const nlohmann::ordered_json& a, const nlohmann::ordered_json& b, const DiffOptions& options);

/// The names of the figures that are worse, with their changes: "p99 by 15.3 %". Empty if none is.
std::string worse_figures(const RunDiff& diff);

/// A table, and what else should be known.
std::string to_text(const RunDiff& diff);

/// {"format": "segserve-bench-diff-1", "allow_percent", "confidence_percent", "seed", "verdict", "rows", "caveats"}.
/// Infinite numbers are null, and their row has "is_infinite": true.
nlohmann::ordered_json to_json(const RunDiff& diff);

}  // namespace segserve::bench_report
