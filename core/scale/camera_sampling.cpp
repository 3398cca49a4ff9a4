// SPDX-License-Identifier: Apache-2.0
#include "core/scale/camera_sampling.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/scale/quantile.hpp"
#include "core/voxels/point_selection.hpp"

namespace segserve {
namespace {

constexpr std::size_t kColumns = 5;         // a group has so many columns in each direction
constexpr float kWidestTangent = 2.05F;     // of 64 degrees
constexpr std::size_t kFewestGroups = 16;   // fewer tell nothing
constexpr std::size_t kFewestColumns = 15;  // of a group, for a plane

/// Integer sums, so that the order of the points does not matter.
struct Column {
  std::int64_t points = 0, u = 0, v = 0, inverse_depth = 0;
};

class Group {
 public:
  static constexpr float kPositionScale = 4096;          // of u and v, in a group's width
  static constexpr float kInverseDepthScale = 16777216;  // 2^24 for 1/m
  static constexpr float kNearest = 0.02F;               // meters; keeps the sums within 64 bits

  void add(float u, float v, float inverse_depth) {
    constexpr auto kWidth = static_cast<float>(kColumns);
    const auto row = static_cast<std::size_t>(v * kWidth), place = static_cast<std::size_t>(u * kWidth);
    Column& column = columns_[row * kColumns + place];
    column.points += 1;
    column.u += static_cast<std::int64_t>(u * kPositionScale);
    column.v += static_cast<std::int64_t>(v * kPositionScale);
    column.inverse_depth += static_cast<std::int64_t>(inverse_depth * kInverseDepthScale);
  }

  std::int64_t points() const {
    std::int64_t sum = 0;
    for (const Column& column : columns_) sum += column.points;
    return sum;
  }

  struct Residual {
    double inverse_depth = 0;  ///< mean, 1/m
    double deviation = 0;      ///< standard deviation about the plane, 1/m
    double gradient = 0;       ///< of the plane, 1/m across the width of a group
  };

  /// The residual of the plane that fits the columns; nullopt if there are too few of them.
  std::optional<Residual> residual() const {
    double n = 0, su = 0, sv = 0, sw = 0;
    for_each_column([&](double u, double v, double w) { n += 1, su += u, sv += v, sw += w; });
    if (n < static_cast<double>(kFewestColumns)) return std::nullopt;
    const double mu = su / n, mv = sv / n, mw = sw / n;
    double uu = 0, uv = 0, vv = 0, uw = 0, vw = 0, ww = 0;
    for_each_column([&](double u, double v, double w) {
      u -= mu, v -= mv, w -= mw;
      uu += u * u, uv += u * v, vv += v * v, uw += u * w, vw += v * w, ww += w * w;
    });
    const double determinant = uu * vv - uv * uv;
    if (!(determinant > 1e-9 * uu * vv)) return std::nullopt;
    const double a = (uw * vv - vw * uv) / determinant, b = (vw * uu - uw * uv) / determinant;
    return Residual{mw, std::sqrt(std::max(0.0, ww - a * uw - b * vw) / (n - 3)),
                    kPositionScale * std::sqrt(a * a + b * b)};
  }

 private:
  template <typename Each>
  void for_each_column(Each&& each) const {
    for (const Column& column : columns_) {
      if (column.points == 0) continue;
      const double scale = 1 / static_cast<double>(column.points);
      each(scale * static_cast<double>(column.u), scale * static_cast<double>(column.v),
           scale / kInverseDepthScale * static_cast<double>(column.inverse_depth));
    }
  }

  std::array<Column, kColumns * kColumns> columns_{};
};

/// Every second group of every second row of them.
std::vector<Group> gather_groups(const FrameContext& frame, float group_edge, StopCheck& check) {
  const auto width = static_cast<std::int32_t>(2 * kWidestTangent / group_edge) + 2;
  const float scale = 1 / group_edge, middle = 0.5F * static_cast<float>(width);
  const PointSelection selection(frame.options, frame.view());
  std::vector<std::uint32_t> group_at(static_cast<std::size_t>(width) * static_cast<std::size_t>(width));
  std::vector<Group> groups;
  const CloudView& cloud = frame.cloud;
  check.for_each(0, cloud.size(), [&](std::size_t i) {
    const float z = cloud.z[i];
    if (!(z >= Group::kNearest) || !selection.selects(cloud.x[i], cloud.y[i], z)) return;
    const float inverse = 1 / z;
    const float u = cloud.x[i] * inverse * scale + middle, v = cloud.y[i] * inverse * scale + middle;
    const auto limit = static_cast<float>(width);
    if (!(u >= 0 && u < limit && v >= 0 && v < limit)) return;
    const auto column = static_cast<std::int32_t>(u), row = static_cast<std::int32_t>(v);
    if (((column | row) & 1) != 0) return;
    std::uint32_t& group =
        group_at[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column)];
    if (group == 0) {
      groups.emplace_back();
      group = static_cast<std::uint32_t>(groups.size());
    }
    groups[group - 1].add(u - static_cast<float>(column), v - static_cast<float>(row), inverse);
  });
  return groups;
}

double pitch_of(const std::vector<Group>& groups, double group_edge) {
  std::vector<double> points;
  points.reserve(groups.size());
  for (const Group& group : groups) points.push_back(static_cast<double>(group.points()));
  // Groups at the edge of a surface are not full.
  const double full = quantile(points, 0.75);
  return full < 1 ? 0 : group_edge / std::sqrt(full);
}

/// Sets noise and slope.
void measure_depths(const std::vector<Group>& groups, double group_edge, CameraSampling& sampling) {
  std::vector<Group::Residual> residuals;
  for (const Group& group : groups) {
    if (const auto residual = group.residual()) residuals.push_back(*residual);
  }
  if (residuals.size() < kFewestGroups) return;
  std::vector<double> inverse_depths, deviations;
  for (const auto& residual : residuals) inverse_depths.push_back(residual.inverse_depth);
  const double middle = quantile(inverse_depths, 0.5);
  for (const auto& residual : residuals) {
    if (residual.inverse_depth <= middle) deviations.push_back(residual.deviation);
  }
  sampling.noise = quantile(deviations, 0.4);
  std::vector<double> slopes;
  for (const auto& residual : residuals) {
    const bool is_flat = residual.deviation <= std::max(2 * sampling.noise, 0.02 * residual.gradient);
    if (residual.inverse_depth <= middle && is_flat) slopes.push_back(residual.gradient * sampling.pitch / group_edge);
  }
  if (slopes.size() >= kFewestGroups) sampling.slope = quantile(slopes, 0.9);
}

}  // namespace

CameraSampling estimate_camera_sampling(const FrameContext& frame, double edge, StopCheck& check) {
  const double group_edge = static_cast<double>(kColumns) * edge;
  const std::vector<Group> groups = gather_groups(frame, static_cast<float>(group_edge), check);
  if (groups.size() < kFewestGroups || check.stopped()) return {};
  CameraSampling sampling;
  sampling.pitch = pitch_of(groups, group_edge);
  measure_depths(groups, group_edge, sampling);
  return sampling;
}

}  // namespace segserve
