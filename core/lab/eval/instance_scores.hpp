// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/lab/eval/contingency.hpp"
#include "core/lab/eval/scores.hpp"

namespace segserve::eval {

// Scores that count parts instead of points. Label 0 of a segmentation is no segment here: what the method left out
// is neither a right nor a wrong detection. Overlaps are measured on the points that have ground truth.

/// For each segment of the table, whether it claims to be one of the regions `which`. All segments but label 0 do so
/// for kAll. For kObjects those do that have at least half of their points in objects. A segmentation does not say
/// which of its segments are objects, so segments of the support are left out of the count.
std::vector<bool> detections(const Contingency& table, Regions which);

/// Panoptic quality (Kirillov et al. 2019) without classes. A detection and a region match if their intersection over
/// union (IoU) is above 0.5, which happens at most once for each of both.
struct PanopticScores {
  double pq = 0;             ///< Sum of the IoU of all matches / (matches + half of the unmatched parts): sq * rq.
  std::optional<double> sq;  ///< Mean IoU of the matches; unset without a match.
  double rq = 0;             ///< Matches / (matches + half of the unmatched detections and regions).
};
/// Unset if no region is scored.
std::optional<PanopticScores> panoptic_scores(const Contingency& table, Regions which);

/// Average precision and recall of the objects as instances without classes. A detection and an object match at the
/// threshold T if their IoU is above T. A segmentation gives no confidences, so all of its detections stand at one
/// rank, and the precision-recall curve is one step: precision P up to recall R, then 0. Its area is AP = P * R.
/// Recall is AR = R.
struct InstanceScores {
  double ap = 0, ar = 0;      ///< Means over T = 0.5, 0.55 and so on up to 0.95.
  double ap50 = 0, ar50 = 0;  ///< At T = 0.5.
  double ap75 = 0, ar75 = 0;  ///< At T = 0.75.
};
/// Unset if there is no object.
std::optional<InstanceScores> instance_scores(const Contingency& table);

/// How many objects were not found as they are, by the tolerance of Hoover et al. (1996), 80 %. An object is missed if
/// more than half of its points are in no segment. Any other object is found if the segment that holds most of it
/// (ties by label) holds at least 80 % of it and lies at least 80 % in it. Else it is over-segmented, under-segmented
/// or both.
struct ObjectCounts {
  std::uint32_t objects = 0;
  std::uint32_t over_segmented = 0;   ///< That segment holds less than 80 % of the object.
  std::uint32_t under_segmented = 0;  ///< That segment lies less than 80 % in the object.
  std::uint32_t missed = 0;
};
ObjectCounts count_objects(const Contingency& table);

}  // namespace segserve::eval
