// SPDX-License-Identifier: Apache-2.0
#include "core/merging/spanning_borders.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

#include "core/base/stop_check.hpp"
#include "core/math/symmetric_matrix3.hpp"
#include "core/weights/color_difference.hpp"

namespace segserve {
namespace {

constexpr double kLargest = 0.05;  // part of the scene's voxels
/// Part of the width of either segment that a border must span: where the colors are alike, and for each unit of
/// CIEDE2000 by which they differ.
constexpr double kLeastPart = 0.55, kPartPerDifference = 0.02;
/// Largest difference of the colors. In one view things hide each other, and borders are seen in part.
constexpr double kOneView = 7, kAllAround = 20;
constexpr double kWithoutColor = 14;  // the difference that counts where there is no color
constexpr double kFewestContacts = 4;
/// The mean evidence that is left. It is small enough to merge the largest regions at the usual threshold, and large
/// enough that smooth surfaces merge first.
constexpr double kEvidenceLeft = 10;
constexpr std::size_t kMostSamples = 4096;  // voxels by which the width of a segment is measured

/// Sums over a segment.
struct SegmentSums {
  double voxels = 0, points = 0;
  Vec3 color_sum;
};

class Range {
 public:
  void add(double value) { low_ = std::min(low_, value), high_ = std::max(high_, value); }
  double length() const { return std::max(0.0, high_ - low_); }

 private:
  double low_ = std::numeric_limits<double>::infinity(), high_ = -std::numeric_limits<double>::infinity();
};

/// The voxels along the border of two segments.
struct SegmentBorder {
  SegmentBorder(std::uint32_t smaller, std::uint32_t larger, double part) : a(smaller), b(larger), least_part(part) {}

  std::uint32_t a, b;  // segments, a < b
  double least_part;   // of their widths that it must span
  double contacts = 0;
  Vec3 origin;  // a voxel of it, so that sums are of small numbers
  Vec3 sum;
  Symmetric3 squares;

  void add(const Vec3& voxel) {
    if (contacts == 0) origin = voxel;
    const Vec3 d = voxel - origin;
    contacts += 0.5;  // Each contact has two voxels.
    sum += d;
    squares += outer(d);
  }
  /// A unit vector along the border, or zero if it is no line.
  Vec3 direction() const {
    Symmetric3 scatter = squares;
    scatter += (-0.5 / contacts) * outer(sum);
    // The largest eigenvector is the smallest of the matrix that has the eigenvalues trace - e.
    const double trace = scatter.xx + scatter.yy + scatter.zz;
    return smallest_eigenvector(
        {trace - scatter.xx, -scatter.xy, -scatter.xz, trace - scatter.yy, -scatter.yz, trace - scatter.zz});
  }
};

/// The borders between the segments of a first cut, as far as they may lie within one thing.
class SegmentBorders {
 public:
  SegmentBorders(const FrameContext& frame, const VoxelGrid& grid, const Supervoxels& supervoxels,
                 const RegionGraph& graph, const Cut& cut, StopCheck& check)
      : frame_(frame),
        grid_(grid),
        supervoxels_(supervoxels),
        graph_(graph),
        segment_of_(cut.segment_of_leaf),
        check_(check),
        sums_(cut.segments + 1),
        border_of_edge_(graph.edges.size(), 0) {}

  /// Finds the borders of segments that are small enough and of similar colors. Returns whether there are any.
  bool find() {
    check_.for_each(0, graph_.regions.size(), [&](std::size_t r) {
      SegmentSums& sums = sums_[segment_of_[r]];
      const Region& region = graph_.regions[r];
      sums.voxels += region.voxels, sums.points += region.points, sums.color_sum += region.color_sum;
    });
    std::vector<std::pair<std::uint64_t, std::uint32_t>> edges;  // (segments, edge)
    check_.for_each(0, graph_.edges.size(), [&](std::size_t e) {
      const auto [a, b] = std::minmax(segment_of_[graph_.edges[e].a], segment_of_[graph_.edges[e].b]);
      if (a == b || is_large(a) || is_large(b)) return;
      edges.emplace_back(std::uint64_t{a} << 32U | b, static_cast<std::uint32_t>(e));
    });
    std::ranges::sort(edges);
    const double most_difference = frame_.has_hidden_parts() ? kOneView : kAllAround;
    for (std::size_t i = 0; i < edges.size() && !check_.after(1);) {
      const std::uint64_t key = edges[i].first;
      const auto a = static_cast<std::uint32_t>(key >> 32U), b = static_cast<std::uint32_t>(key);
      const double difference = color_difference(a, b);
      const bool is_candidate = difference <= most_difference;
      if (is_candidate) borders_.emplace_back(a, b, kLeastPart + kPartPerDifference * difference);
      for (; i < edges.size() && edges[i].first == key; ++i) {
        if (is_candidate) border_of_edge_[edges[i].second] = static_cast<std::uint32_t>(borders_.size());
      }
    }
    return !borders_.empty();
  }

  /// Keeps those that span both of their segments. Returns whether there are any.
  bool keep_spanning() {
    check_.for_each(0, graph_.contacts.size(), [&](std::size_t c) {
      const std::uint32_t border = border_of_edge_[graph_.edge_of_contact[c]];
      if (border == 0) return;
      borders_[border - 1].add(grid_.centroid[graph_.contacts[c].v]);
      borders_[border - 1].add(grid_.centroid[graph_.contacts[c].u]);
    });
    gather_voxels();
    std::vector<Vec3> directions(borders_.size());
    std::vector<Range> lengths(borders_.size());
    for (std::size_t i = 0; i < borders_.size(); ++i) directions[i] = borders_[i].direction();
    check_.for_each(0, graph_.contacts.size(), [&](std::size_t c) {
      const std::uint32_t border = border_of_edge_[graph_.edge_of_contact[c]];
      if (border == 0) return;
      lengths[border - 1].add(dot(directions[border - 1], grid_.centroid[graph_.contacts[c].v]));
      lengths[border - 1].add(dot(directions[border - 1], grid_.centroid[graph_.contacts[c].u]));
    });
    is_spanning_.resize(borders_.size());
    bool any = false;
    for (std::size_t i = 0; i < borders_.size(); ++i) {
      const SegmentBorder& border = borders_[i];
      const double length = lengths[i].length();
      is_spanning_[i] = border.contacts >= kFewestContacts && length > 0 &&
                        length >= border.least_part * width(border.a, directions[i]) &&
                        length >= border.least_part * width(border.b, directions[i]);
      any = any || is_spanning_[i];
    }
    return any;
  }

  bool is_within_thing(std::size_t edge) const {
    return border_of_edge_[edge] != 0 && is_spanning_[border_of_edge_[edge] - 1];
  }

 private:
  bool is_large(std::uint32_t segment) const {
    return sums_[segment].voxels > kLargest * static_cast<double>(grid_.size());
  }

  double color_difference(std::uint32_t a, std::uint32_t b) const {
    return frame_.cloud.rgb.empty() ? kWithoutColor : ciede2000(color_of(a), color_of(b));
  }
  Lab color_of(std::uint32_t segment) const {
    return srgb_to_lab((1 / sums_[segment].points) * sums_[segment].color_sum);
  }

  /// Lists the voxels of each segment, or so many of them as its width needs.
  void gather_voxels() {
    std::vector<bool> is_needed(sums_.size());
    for (const SegmentBorder& border : borders_) is_needed[border.a] = is_needed[border.b] = true;
    std::vector<std::size_t> stride(sums_.size()), seen(sums_.size());
    for (std::size_t s = 0; s < sums_.size(); ++s) {
      stride[s] = is_needed[s] ? 1 + static_cast<std::size_t>(sums_[s].voxels) / kMostSamples : 0;
    }
    voxels_.resize(sums_.size());
    check_.for_each(0, grid_.size(), [&](std::size_t v) {
      const std::uint32_t s = segment_of_[supervoxels_.supervoxel_of_voxel[v]];
      if (stride[s] > 0 && seen[s]++ % stride[s] == 0) voxels_[s].push_back(static_cast<std::uint32_t>(v));
    });
  }

  /// How far a segment extends in a direction, meters.
  double width(std::uint32_t segment, const Vec3& direction) {
    Range range;
    check_.for_each(0, voxels_[segment].size(),
                    [&](std::size_t i) { range.add(dot(direction, grid_.centroid[voxels_[segment][i]])); });
    return range.length();
  }

  const FrameContext& frame_;
  const VoxelGrid& grid_;
  const Supervoxels& supervoxels_;
  const RegionGraph& graph_;
  const std::vector<std::uint32_t>& segment_of_;  // of each region, from 1 on
  StopCheck& check_;
  std::vector<SegmentSums> sums_;  // of each segment
  std::vector<SegmentBorder> borders_;
  std::vector<std::uint32_t> border_of_edge_;       // 1 + its place in borders_; 0: none of them
  std::vector<bool> is_spanning_;                   // of each border
  std::vector<std::vector<std::uint32_t>> voxels_;  // of each segment with a border
};

}  // namespace

absl::StatusOr<bool> lessen_spanning_borders(const FrameContext& frame, const VoxelGrid& grid,
                                             const Supervoxels& supervoxels, const RegionGraph& graph, const Cut& cut,
                                             std::vector<BorderEvidence>& evidence) {
  if (frame.cloud.rgb.empty() && frame.view().has_sensor()) return false;
  StopCheck check(frame.stop);
  SegmentBorders borders(frame, grid, supervoxels, graph, cut, check);
  const bool has_changed = borders.find() && borders.keep_spanning();
  check.for_each(0, has_changed ? graph.edges.size() : 0, [&](std::size_t e) {
    if (borders.is_within_thing(e)) evidence[e].sum = std::min(evidence[e].sum, kEvidenceLeft * evidence[e].contacts);
  });
  if (check.stopped()) return check.status();
  return has_changed;
}

}  // namespace segserve
