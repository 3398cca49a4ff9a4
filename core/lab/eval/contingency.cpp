// SPDX-License-Identifier: Apache-2.0
#include "core/lab/eval/contingency.hpp"

#include <algorithm>
#include <unordered_map>
#include <utility>

#include "core/base/status_macros.hpp"
#include "fmt/format.h"

namespace segserve::eval {
namespace {

/// The index of the part with this label, which is added if it is not there.
std::uint32_t index_of(std::vector<Part>& parts, std::uint32_t label) {
  auto part = std::ranges::lower_bound(parts, label, {}, &Part::label);
  if (part == parts.end() || part->label != label) part = parts.insert(part, {label, 0});
  return static_cast<std::uint32_t>(part - parts.begin());
}

/// Adds the segments of a cut to `table`. Returns, for every supervoxel, the index of its segment there.
absl::StatusOr<std::vector<std::uint32_t>> add_segments(const Contingency& supervoxels, const Cut& cut,
                                                        Contingency& table) {
  std::vector<std::uint64_t> points(std::size_t{cut.segments} + 1, 0);
  std::vector<std::uint32_t> label;
  for (const Part& supervoxel : supervoxels.segments) {
    if (supervoxel.label > cut.segment_of_leaf.size()) {
      return absl::InvalidArgumentError(fmt::format("supervoxel {} is not a leaf of the tree, which has {}",
                                                    supervoxel.label, cut.segment_of_leaf.size()));
    }
    label.push_back(supervoxel.label == 0 ? 0 : cut.segment_of_leaf[supervoxel.label - 1]);
    points[label.back()] += supervoxel.points;
  }
  std::vector<std::uint32_t> index(points.size());
  for (std::uint32_t s = 0; s < points.size(); ++s) {
    if (points[s] == 0) continue;
    index[s] = static_cast<std::uint32_t>(table.segments.size());
    table.segments.push_back({s, points[s]});
  }
  for (std::uint32_t& l : label) l = index[l];
  return label;
}

}  // namespace

absl::StatusOr<Contingency> tabulate(std::span<const std::uint32_t> truth, std::span<const std::uint32_t> labels) {
  if (truth.size() != labels.size()) {
    return absl::InvalidArgumentError(
        fmt::format("{} points have ground truth, {} have labels", truth.size(), labels.size()));
  }
  std::unordered_map<std::uint64_t, std::uint64_t> joint;  // (truth, label) -> points
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (truth[i] != 0) ++joint[std::uint64_t{truth[i]} << 32U | labels[i]];
  }
  if (joint.empty()) return absl::InvalidArgumentError("no point has a ground-truth label other than 0");

  Contingency table;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> pairs(joint.begin(), joint.end());
  std::ranges::sort(pairs);
  for (const auto& [pair, points] : pairs) {
    index_of(table.regions, static_cast<std::uint32_t>(pair >> 32U));
    index_of(table.segments, static_cast<std::uint32_t>(pair));
  }
  for (const auto& [pair, points] : pairs) {
    const Overlap overlap{index_of(table.regions, static_cast<std::uint32_t>(pair >> 32U)),
                          index_of(table.segments, static_cast<std::uint32_t>(pair)), points};
    table.regions[overlap.region].points += points;
    table.segments[overlap.segment].points += points;
    table.points += points;
    table.overlaps.push_back(overlap);
  }
  return table;
}

absl::StatusOr<Contingency> coarsen(const Contingency& supervoxels, const Cut& cut) {
  Contingency table;
  table.regions = supervoxels.regions;
  table.points = supervoxels.points;
  ASSIGN_OR_RETURN(const auto segment_of, add_segments(supervoxels, cut, table));

  std::vector<Overlap> fine = supervoxels.overlaps;
  for (Overlap& overlap : fine) overlap.segment = segment_of[overlap.segment];
  std::ranges::sort(fine, {}, [](const Overlap& o) { return std::pair(o.region, o.segment); });
  for (const Overlap& overlap : fine) {
    const bool same = !table.overlaps.empty() && table.overlaps.back().region == overlap.region &&
                      table.overlaps.back().segment == overlap.segment;
    if (same) {
      table.overlaps.back().points += overlap.points;
    } else {
      table.overlaps.push_back(overlap);
    }
  }
  return table;
}

}  // namespace segserve::eval
