// SPDX-License-Identifier: Apache-2.0
#include "core/lab/eval/overlap_scores.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/lab/eval/assignment.hpp"
#include "core/lab/eval/instance_scores.hpp"
#include "core/lab/eval/scores.hpp"

namespace segserve::eval {
namespace {

/// The harmonic mean of |g n s| / |s| and |g n s| / |g|.
double f_measure(const Contingency& table, const Overlap& o) {
  return 2 * static_cast<double>(o.points) /
         static_cast<double>(table.regions[o.region].points + table.segments[o.segment].points);
}

/// The overlaps of each object with detections.
std::vector<std::vector<Overlap>> candidates(const Contingency& table, const std::vector<bool>& detection) {
  std::vector<std::vector<Overlap>> objects;
  for (std::uint32_t r = 0; r < table.regions.size(); ++r) {
    if (table.regions[r].label < kFirstObjectLabel) continue;
    objects.emplace_back();
    for (const Overlap& o : std::ranges::equal_range(table.overlaps, r, {}, &Overlap::region)) {
      if (detection[o.segment]) objects.back().push_back(o);
    }
  }
  // With n objects, at most n - 1 of an object's candidates can be taken by others: its n best ones are enough.
  for (std::vector<Overlap>& object : objects) {
    std::ranges::stable_sort(object, std::ranges::greater{}, [&](const Overlap& o) { return f_measure(table, o); });
    if (object.size() > objects.size()) object.resize(objects.size());
  }
  return objects;
}

/// The pairs of the best assignment that have common points.
std::vector<Overlap> matched(const Contingency& table, const std::vector<std::vector<Overlap>>& objects) {
  std::vector<std::uint32_t> segments;
  for (const auto& object : objects) {
    for (const Overlap& o : object) segments.push_back(o.segment);
  }
  std::ranges::sort(segments);
  segments.erase(std::ranges::unique(segments).begin(), segments.end());

  const std::size_t rows = objects.size();
  const std::size_t columns = std::max(segments.size(), rows);
  const auto column = [&](const Overlap& o) {
    return static_cast<std::size_t>(std::ranges::lower_bound(segments, o.segment) - segments.begin());
  };
  std::vector<double> weights(rows * columns, 0);
  for (std::size_t row = 0; row < rows; ++row) {
    for (const Overlap& o : objects[row]) weights[row * columns + column(o)] = f_measure(table, o);
  }
  const std::vector<std::size_t> assigned = best_assignment(weights, rows, columns);
  std::vector<Overlap> pairs;
  for (std::size_t row = 0; row < rows; ++row) {
    const auto pair = std::ranges::find(objects[row], assigned[row], column);
    if (pair != objects[row].end()) pairs.push_back(*pair);
  }
  return pairs;
}

}  // namespace

std::optional<OverlapScores> overlap_scores(const Contingency& table) {
  const std::vector<bool> detection = detections(table, Regions::kObjects);
  const std::vector<std::vector<Overlap>> objects = candidates(table, detection);
  if (objects.empty()) return std::nullopt;

  double common = 0, detected = 0, wanted = 0, good = 0;
  for (const Overlap& pair : matched(table, objects)) {
    common += static_cast<double>(pair.points);
    if (f_measure(table, pair) >= 0.75) ++good;
  }
  for (std::size_t s = 0; s < detection.size(); ++s) {
    if (detection[s]) detected += static_cast<double>(table.segments[s].points);
  }
  for (const Part& region : table.regions) {
    if (region.label >= kFirstObjectLabel) wanted += static_cast<double>(region.points);
  }
  OverlapScores scores;
  scores.recall = common / wanted;
  scores.objects_f75 = good / static_cast<double>(objects.size());
  if (detected > 0) {
    scores.precision = common / detected;
    scores.f = 2 * common / (detected + wanted);  // the harmonic mean of common / detected and common / wanted
  }
  return scores;
}

}  // namespace segserve::eval
