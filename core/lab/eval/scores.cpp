// SPDX-License-Identifier: Apache-2.0
#include "core/lab/eval/scores.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace segserve::eval {
namespace {

double ratio(std::uint64_t numerator, std::uint64_t denominator) {
  return denominator == 0 ? 0 : static_cast<double>(numerator) / static_cast<double>(denominator);
}

double intersection_over_union(const Contingency& table, const Overlap& o) {
  return ratio(o.points, table.regions[o.region].points + table.segments[o.segment].points - o.points);
}

/// The overlaps of a region, which are neighbors in the table.
std::span<const Overlap> overlaps_of(const Contingency& table, std::uint32_t region) {
  const auto range = std::ranges::equal_range(table.overlaps, region, {}, &Overlap::region);
  return {range.begin(), range.end()};
}

}  // namespace

Scores paper_scores(const Contingency& table, Regions which) {
  Scores sum;
  double regions = 0;
  double points = 0;
  for (std::uint32_t r = 0; r < table.regions.size(); ++r) {
    const Part& region = table.regions[r];
    if (which == Regions::kObjects && region.label < kFirstObjectLabel) continue;
    const Overlap best = *std::ranges::max_element(overlaps_of(table, r), {},
                                                   [&](const Overlap& o) { return intersection_over_union(table, o); });
    const std::uint64_t size = table.segments[best.segment].points;
    sum.wov += intersection_over_union(table, best) * static_cast<double>(region.points);
    sum.tp += ratio(best.points, region.points);
    sum.fp += ratio(size - best.points, size);
    points += static_cast<double>(region.points);
    regions += 1;
  }
  if (regions == 0) return {};
  return {sum.wov / points, sum.tp / regions, sum.fp / regions, 1 - sum.tp / regions, 0};
}

Scores one_to_one_scores(const Contingency& table) {
  std::vector<std::uint32_t> order(table.regions.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::stable_sort(order, std::ranges::greater{}, [&](std::uint32_t r) { return table.regions[r].points; });
  std::vector<bool> taken(table.segments.size(), false);
  Scores s;
  double precision = 0;
  for (const std::uint32_t r : order) {
    const std::uint64_t size = table.regions[r].points;
    const Overlap* best = nullptr;
    for (const Overlap& o : overlaps_of(table, r)) {
      if (!taken[o.segment] && (best == nullptr || o.points > best->points)) best = &o;
    }
    if (best == nullptr) {
      s.fn += static_cast<double>(size);
      continue;
    }
    taken[best->segment] = true;
    const std::uint64_t segment = table.segments[best->segment].points;
    s.tp += static_cast<double>(best->points);
    s.fp += static_cast<double>(segment - best->points);
    s.fn += static_cast<double>(size - best->points);
    s.wov += static_cast<double>(size) * intersection_over_union(table, *best);
    precision += static_cast<double>(best->points) * ratio(size, segment);
  }
  const double n = static_cast<double>(table.points);
  s = {s.wov / n, s.tp / n, s.fp / n, s.fn / n, 0};
  precision /= n;
  s.f = precision + s.tp > 0 ? 2 * precision * s.tp / (precision + s.tp) : 0;
  return s;
}

double variation_of_information(const Contingency& table) {
  double bits = 0;
  for (const Overlap& o : table.overlaps) {
    bits -= ratio(o.points, table.points) * (std::log2(ratio(o.points, table.regions[o.region].points)) +
                                             std::log2(ratio(o.points, table.segments[o.segment].points)));
  }
  return bits;
}

SupervoxelScores supervoxel_scores(const Contingency& table) {
  std::vector<std::uint64_t> largest(table.segments.size(), 0);
  std::uint64_t leaking = 0;
  for (const Overlap& o : table.overlaps) {
    largest[o.segment] = std::max(largest[o.segment], o.points);
    leaking += std::min(o.points, table.segments[o.segment].points - o.points);
  }
  return {ratio(std::accumulate(largest.begin(), largest.end(), std::uint64_t{0}), table.points),
          ratio(leaking, table.points)};
}

}  // namespace segserve::eval
