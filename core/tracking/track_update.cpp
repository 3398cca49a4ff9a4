// SPDX-License-Identifier: Apache-2.0
#include "core/tracking/track_update.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/math/elementary.hpp"
#include "core/math/symmetric_matrix3.hpp"
#include "core/statistics/principal_axes.hpp"
#include "core/tracking/state_limits.hpp"

namespace segserve::tracking {
namespace {

constexpr double kSteps = 32767;     // of a signature's place
constexpr double kSmallest = 1e-6;   // meters: a step of 0 would be none
constexpr double kDeviations = 2.5;  // half extents of a box at most, so that single supervoxels do not widen it

/// Numbers of a state, which stay within its limits whatever the state before was.
std::array<float, 3> floats(const Vec3& v, double most = kFarthest) {
  const auto bounded = [most](double number) { return static_cast<float>(std::clamp(number, -most, most)); };
  return {bounded(v.x), bounded(v.y), bounded(v.z)};
}

std::uint8_t to_byte(double channel) {
  return static_cast<std::uint8_t>(math::floor_to_int(std::clamp(channel, 0.0, 255.0) + 0.5));
}
std::array<std::uint8_t, 3> to_rgb(const Vec3& color) { return {to_byte(color.x), to_byte(color.y), to_byte(color.z)}; }

double largest(const Vec3& v) { return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)}); }

/// Sets the step and the places of the signatures, which are `offsets` meters from the center.
void set_places(std::span<const Vec3> offsets, TrackState::Track& track) {
  double reach = kSmallest;
  for (const Vec3& offset : offsets) reach = std::max(reach, largest(offset));
  // Rounded up, so that no place is beyond the last step.
  constexpr double kUp = 1.000001;
  track.step = static_cast<float>(std::min(reach * kUp / kSteps, kFarthest));
  const auto steps = [&](double meters) {
    const double exact = std::clamp(meters / static_cast<double>(track.step), -kSteps, kSteps);
    return static_cast<std::int16_t>(math::floor_to_int(exact + 0.5));
  };
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    track.signatures[i].place = {steps(offsets[i].x), steps(offsets[i].y), steps(offsets[i].z)};
  }
}

Eigen::Matrix3d to_matrix(const Symmetric3& a) {
  Eigen::Matrix3d matrix;
  matrix << a.xx, a.xy, a.xz, a.xy, a.yy, a.yz, a.xz, a.yz, a.zz;
  return matrix;
}

void set_box(const SceneTree& scene, std::span<const std::uint32_t> leaves, const Vec3& center, double area,
             TrackState::Track& track) {
  Symmetric3 scatter;
  for (const std::uint32_t leaf : leaves) scatter += scene.leaf_area(leaf) * outer(scene.leaf_center(leaf) - center);
  const Eigen::Matrix3d axes = principal_axes(to_matrix(scatter));
  std::array<Vec3, 3> axis;
  for (std::size_t k = 0; k < 3; ++k) axis[k] = to_vec3(axes.col(static_cast<Eigen::Index>(k)));
  for (std::size_t k = 0; k < 3; ++k) {
    double farthest = 0, squares = 0;
    for (const std::uint32_t leaf : leaves) {
      const double along = dot(axis[k], scene.leaf_center(leaf) - center);
      farthest = std::max(farthest, std::fabs(along));
      squares += scene.leaf_area(leaf) * along * along;
    }
    track.half_extents[k] = static_cast<float>(std::min(farthest, kDeviations * std::sqrt(squares / area)));
  }
  const std::array<float, 3> first = floats(axis[0]), second = floats(axis[1]);
  std::ranges::copy(first, track.axes.begin());
  std::ranges::copy(second, track.axes.begin() + 3);
}

}  // namespace

TrackState::Track describe_track(const SceneTree& scene, std::span<const std::uint32_t> leaves) {
  NodeFeatures sum;
  for (const std::uint32_t leaf : leaves) sum.add(scene.node(leaf));
  TrackState::Track track;
  track.age = 1, track.trust = 1;
  track.center = floats(sum.center());
  track.area = static_cast<float>(sum.area);
  track.rgb = to_rgb(sum.color());
  set_box(scene, leaves, sum.center(), sum.area, track);

  const std::size_t count = std::min(leaves.size(), TrackState::kMostSignatures);
  std::vector<Vec3> offsets;
  const Vec3 center{track.center[0], track.center[1], track.center[2]};
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t leaf = leaves[i * leaves.size() / count];
    offsets.push_back(scene.leaf_center(leaf) - center);
    track.signatures.push_back({.place = {}, .rgb = to_rgb(scene.leaf_color(leaf))});
  }
  set_places(offsets, track);
  return track;
}

TrackState::Track carry_on(const TrackState::Track& before, const PredictedTrack& predicted) {
  constexpr double kSlowing = 0.7;  // of a frame
  TrackState::Track track = before;
  ++track.lost;
  track.center = floats(predicted.center);
  const std::array<float, 3> first = floats(predicted.axes[0], kLongestAxis);
  const std::array<float, 3> second = floats(predicted.axes[1], kLongestAxis);
  std::ranges::copy(first, track.axes.begin());
  std::ranges::copy(second, track.axes.begin() + 3);
  track.velocity = floats(kSlowing * predicted.velocity);
  std::vector<Vec3> offsets;
  offsets.reserve(predicted.signatures.size());
  const Vec3 center{track.center[0], track.center[1], track.center[2]};
  for (const PredictedTrack::Signature& signature : predicted.signatures) offsets.push_back(signature.place - center);
  set_places(offsets, track);
  return track;
}

std::array<float, 3> new_velocity(const PredictedTrack& predicted, const std::array<float, 3>& center, double seconds) {
  const Vec3 now{center[0], center[1], center[2]};
  const Vec3 seen = (1 / seconds) * (now - predicted.center);
  return floats(0.5 * (predicted.velocity + seen));
}

}  // namespace segserve::tracking
