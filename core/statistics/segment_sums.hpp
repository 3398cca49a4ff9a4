// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/executor.hpp"
#include "core/base/parallel_parts.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
#include "core/statistics/run_measures.hpp"

namespace segserve {

/// Sums up measures of the points of each segment, run by run.
class SegmentSums {
 public:
  /// `labels`: of all points; 0 and labels above `segments` are left out.
  SegmentSums(std::span<const std::uint32_t> labels, std::uint32_t segments, Executor& executor, const StopToken& stop)
      : labels_(labels), segments_(segments), executor_(executor), stop_(stop) {}

  /// The measures of all segments in one pass over the points: the sums of measure_run(s, begin, end), which measures
  /// points [begin, end) of segment s + 1. CANCELLED, DEADLINE_EXCEEDED.
  template <typename Measure, typename MeasureRun>
  absl::StatusOr<std::vector<Measure>> sum(MeasureRun&& measure_run) const {
    std::vector<std::vector<Measure>> sums(executor_.threads(), std::vector<Measure>(segments_));
    const auto add_part = [&](std::vector<Measure>& sum, std::size_t begin, std::size_t end, StopCheck& check) {
      for (std::size_t i = begin; i < end;) {
        const std::size_t last = std::min(i + kMaxRun, end);
        if (check.after(last - i)) return;
        while (i < last) {
          const std::size_t run = i;
          while (i < last && labels_[i] == labels_[run]) ++i;
          const std::uint32_t s = labels_[run] - 1;  // beyond all segments for label 0
          if (s < segments_) sum[s].add(measure_run(s, run, i));
        }
      }
    };
    RETURN_IF_ERROR(parallel_parts(executor_, stop_, labels_.size(),
                                   [&](unsigned part, std::size_t begin, std::size_t end, StopCheck& check) {
                                     add_part(sums[part], begin, end, check);
                                   }));
    StopCheck check(stop_);
    for (std::size_t part = 1; part < sums.size(); ++part) {
      check.for_each(0, segments_, [&](std::size_t s) { sums[0][s].add(sums[part][s]); });
    }
    RETURN_IF_ERROR(check.status());
    return std::move(sums[0]);
  }

 private:
  std::span<const std::uint32_t> labels_;
  std::uint32_t segments_;
  Executor& executor_;
  const StopToken& stop_;
};

}  // namespace segserve
