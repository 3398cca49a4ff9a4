// SPDX-License-Identifier: Apache-2.0
#include "core/lab/eval/instance_scores.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace segserve::eval {
namespace {

/// T = 0.5, 0.55 and so on up to 0.95 in per cent.
constexpr std::array<std::uint64_t, 10> kThresholds{50, 55, 60, 65, 70, 75, 80, 85, 90, 95};
constexpr std::uint64_t kTolerance = 80;  // per cent

bool is_scored(const Part& region, Regions which) {
  return which == Regions::kAll || region.label >= kFirstObjectLabel;
}

struct Counts {
  std::uint64_t matches = 0;
  std::uint64_t detections = 0;
  std::uint64_t regions = 0;
  double iou = 0;  ///< Sum over the matches.
};

/// Counts the pairs whose IoU is above a threshold of 50 % or more. No part is in two such pairs.
Counts count_matches(const Contingency& table, Regions which, std::uint64_t percent) {
  const std::vector<bool> detection = detections(table, which);
  Counts counts;
  counts.detections = static_cast<std::uint64_t>(std::ranges::count(detection, true));
  counts.regions = static_cast<std::uint64_t>(
      std::ranges::count_if(table.regions, [&](const Part& r) { return is_scored(r, which); }));
  for (const Overlap& o : table.overlaps) {
    if (!detection[o.segment] || !is_scored(table.regions[o.region], which)) continue;
    const std::uint64_t all = table.regions[o.region].points + table.segments[o.segment].points - o.points;
    if (100 * o.points <= percent * all) continue;
    ++counts.matches;
    counts.iou += static_cast<double>(o.points) / static_cast<double>(all);
  }
  return counts;
}

}  // namespace

std::vector<bool> detections(const Contingency& table, Regions which) {
  std::vector<std::uint64_t> points(table.segments.size(), 0);
  for (const Overlap& o : table.overlaps) {
    if (is_scored(table.regions[o.region], which)) points[o.segment] += o.points;
  }
  std::vector<bool> detection(table.segments.size());
  for (std::size_t s = 0; s < detection.size(); ++s) {
    detection[s] = table.segments[s].label != 0 && 2 * points[s] >= table.segments[s].points;
  }
  return detection;
}

std::optional<PanopticScores> panoptic_scores(const Contingency& table, Regions which) {
  const Counts counts = count_matches(table, which, 50);
  if (counts.regions == 0) return std::nullopt;
  // matches + half of what is unmatched on both sides
  const double parts = static_cast<double>(counts.detections + counts.regions) / 2;
  PanopticScores scores{counts.iou / parts, std::nullopt, static_cast<double>(counts.matches) / parts};
  if (counts.matches > 0) scores.sq = counts.iou / static_cast<double>(counts.matches);
  return scores;
}

std::optional<InstanceScores> instance_scores(const Contingency& table) {
  InstanceScores scores;
  for (const std::uint64_t threshold : kThresholds) {
    const Counts counts = count_matches(table, Regions::kObjects, threshold);
    if (counts.regions == 0) return std::nullopt;
    const double matches = static_cast<double>(counts.matches);
    const double recall = matches / static_cast<double>(counts.regions);
    const double precision = counts.matches == 0 ? 0 : matches / static_cast<double>(counts.detections);
    scores.ap += precision * recall / kThresholds.size();
    scores.ar += recall / kThresholds.size();
    if (threshold == 50) scores.ap50 = precision * recall, scores.ar50 = recall;
    if (threshold == 75) scores.ap75 = precision * recall, scores.ar75 = recall;
  }
  return scores;
}

ObjectCounts count_objects(const Contingency& table) {
  ObjectCounts counts;
  for (std::uint32_t r = 0; r < table.regions.size(); ++r) {
    const Part& object = table.regions[r];
    if (!is_scored(object, Regions::kObjects)) continue;
    ++counts.objects;
    std::uint64_t left_out = 0;
    Overlap most;
    for (const Overlap& o : std::ranges::equal_range(table.overlaps, r, {}, &Overlap::region)) {
      if (table.segments[o.segment].label == 0) {
        left_out = o.points;
      } else if (o.points > most.points) {
        most = o;
      }
    }
    if (2 * left_out > object.points) {
      ++counts.missed;
      continue;
    }
    if (100 * most.points < kTolerance * object.points) ++counts.over_segmented;
    if (100 * most.points < kTolerance * table.segments[most.segment].points) ++counts.under_segmented;
  }
  return counts;
}

}  // namespace segserve::eval
