// SPDX-License-Identifier: Apache-2.0
#include "core/scale/sweep_sampling.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "core/math/elementary.hpp"
#include "core/math/vec3.hpp"
#include "core/scale/quantile.hpp"
#include "core/voxels/point_selections.hpp"

namespace segserve {
namespace {

constexpr std::size_t kMostPoints = 1'000'000;  // of a turn
constexpr std::size_t kMostRays = 262'144;      // of a quarter of it
constexpr std::size_t kFewestGaps = 256;        // fewer tell nothing
constexpr double kNarrowestRings = 0.05 * math::kDegree, kWidestRings = 1.5 * math::kDegree;
constexpr double kSliceWidth = 0.25 * math::kDegree;  // about the angle between points of a ring

struct Ray {
  double azimuth, elevation, range;
  bool operator==(const Ray&) const = default;
};

using Rays = std::vector<Ray>;

/// A number in [0, 4) that grows with the azimuth, and needs no arctangent.
double turn_of(double x, double y) {
  const double part = y / (std::fabs(x) + std::fabs(y));
  if (x < 0) return 2 - part;
  return y < 0 ? 4 + part : part;
}

/// The rays of every fourth of 64 sectors, by azimuth.
Rays gather_rays(const FrameContext& frame, StopCheck& check) {
  constexpr double kSectorsOfQuarter = 16;
  const Eigen::Vector3f& sensor = *frame.view().sensor;
  const PointSelection selection = PointSelections(frame.options, frame.view()).at(0).selection;
  const CloudView& cloud = frame.cloud;
  Rays rays;
  check.for_each(0, cloud.size(), [&](std::size_t i) {
    const float x = cloud.x[i], y = cloud.y[i], z = cloud.z[i];
    if (!is_finite(x, y, z) || !selection.selects(x, y, z)) return;
    const Vec3 ray{static_cast<double>(x) - sensor[0], static_cast<double>(y) - sensor[1],
                   static_cast<double>(z) - sensor[2]};
    const double across = ray.x * ray.x + ray.y * ray.y, range = norm(ray);
    if (!(across > 0) || range < SweepProjection::kNearest) return;
    if ((math::floor_to_int(kSectorsOfQuarter * turn_of(ray.x, ray.y)) & 3) != 0) return;
    if (rays.size() <= kMostRays)
      rays.push_back({math::atan2(ray.y, ray.x), math::atan2(ray.z, std::sqrt(across)), range});
  });
  std::ranges::sort(rays, {}, [](const Ray& r) { return std::make_tuple(r.azimuth, r.elevation, r.range); });
  // Drivers that write two echoes a ray write a single one twice.
  const auto repeated = std::ranges::unique(rays);
  rays.erase(repeated.begin(), repeated.end());
  return rays;
}

/// Slices of neighboring azimuths, each sorted by elevation.
std::vector<std::span<Ray>> slices_of(Rays& rays) {
  std::vector<std::span<Ray>> slices;
  const auto slice = [](const Ray& ray) { return math::floor_to_int(ray.azimuth / kSliceWidth); };
  for (std::size_t begin = 0, end = 0; begin < rays.size(); begin = end) {
    while (end < rays.size() && slice(rays[end]) == slice(rays[begin])) ++end;
    slices.emplace_back(rays.data() + begin, end - begin);
    std::ranges::sort(slices.back(), {}, [](const Ray& r) { return std::make_tuple(r.elevation, r.azimuth, r.range); });
  }
  return slices;
}

template <typename Each>
void for_each_pair(const std::vector<std::span<Ray>>& slices, Each&& each) {
  for (const auto& slice : slices) {
    for (std::size_t i = 1; i < slice.size(); ++i) each(slice[i - 1], slice[i]);
  }
}

/// The angle between rings. Neighbors of a slice are of one ring, or of the next one where the slice is narrow; a few
/// are farther apart.
double ring_angle(const std::vector<std::span<Ray>>& slices) {
  std::vector<double> gaps;
  for_each_pair(slices, [&](const Ray& a, const Ray& b) { gaps.push_back(b.elevation - a.elevation); });
  if (gaps.size() < kFewestGaps) return 0;
  const double wide = quantile(gaps, 0.9);
  std::erase_if(gaps, [wide](double gap) { return gap <= 0.25 * wide; });
  return gaps.size() < kFewestGaps ? 0 : quantile(gaps, 0.5);
}

/// The rays by bands of elevation, each sorted by azimuth.
std::vector<std::pair<std::int32_t, Ray>> banded(const Rays& rays, double height) {
  std::vector<std::pair<std::int32_t, Ray>> result;
  result.reserve(rays.size());
  for (const Ray& ray : rays) result.emplace_back(math::floor_to_int(ray.elevation / height), ray);
  std::ranges::sort(result, {}, [](const auto& r) {
    return std::make_tuple(r.first, r.second.azimuth, r.second.elevation, r.second.range);
  });
  return result;
}

/// The angle between neighboring points of a ring, where the bands hold a ring at most.
double azimuth_angle(const Rays& rays, double ring) {
  const auto bands = banded(rays, 0.5 * ring);
  std::vector<double> gaps;
  for (std::size_t i = 1; i < bands.size(); ++i) {
    if (bands[i].first == bands[i - 1].first) gaps.push_back(bands[i].second.azimuth - bands[i - 1].second.azimuth);
  }
  return gaps.size() < kFewestGaps ? 0 : quantile(gaps, 0.5);
}

/// Whether about as many rays go to each part of the scene, however far away it is.
bool is_even(const Rays& rays, const SweepSampling& sampling) {
  constexpr double kRings = 4, kPoints = 4, kMostUneven = 1.9;
  const double height = kRings * sampling.ring, width = std::max(kPoints * sampling.azimuth, math::kDegree);
  std::vector<double> counts;
  std::int32_t last_band = 0, last_column = 0;
  for (const auto& [band, ray] : banded(rays, height)) {
    const std::int32_t column = math::floor_to_int(ray.azimuth / width);
    if (counts.empty() || band != last_band || column != last_column) counts.push_back(0);
    ++counts.back();
    last_band = band, last_column = column;
  }
  if (counts.empty()) return false;
  const double usual = quantile(counts, 0.5);
  return quantile(counts, 0.9) <= kMostUneven * usual;
}

/// Whether rays of nearly the same direction end at nearly the same range. There may be hardly any such rays, and the
/// few of a sensor that moves are those at the edges of things.
bool has_one_surface(const std::vector<std::span<Ray>>& slices, const SweepSampling& sampling) {
  constexpr double kNear = 0.25, kSame = 1.1, kShare = 0.8, kFewOfAll = 0.05;
  std::size_t pairs = 0, same = 0, rays = 0;
  for (const auto& slice : slices) rays += slice.size();
  for_each_pair(slices, [&](const Ray& a, const Ray& b) {
    if (b.elevation - a.elevation > kNear * sampling.ring) return;
    if (std::fabs(b.azimuth - a.azimuth) > 2 * sampling.azimuth) return;
    ++pairs;
    same += static_cast<std::size_t>(std::max(a.range, b.range) <= kSame * std::min(a.range, b.range));
  });
  if (static_cast<double>(pairs - same) <= kFewOfAll * static_cast<double>(rays)) return true;
  return static_cast<double>(same) >= kShare * static_cast<double>(pairs);
}

double slope_of(const std::vector<std::span<Ray>>& slices, double ring) {
  constexpr double kNext = 0.5, kOverNext = 1.5, kShare = 0.8;
  std::vector<double> slopes;
  for_each_pair(slices, [&](const Ray& a, const Ray& b) {
    const double gap = b.elevation - a.elevation;
    if (gap >= kNext * ring && gap <= kOverNext * ring) slopes.push_back(std::fabs(1 / b.range - 1 / a.range) / gap);
  });
  return slopes.size() < kFewestGaps ? 0 : quantile(slopes, kShare);
}

}  // namespace

std::optional<SweepSampling> estimate_sweep_sampling(const FrameContext& frame, StopCheck& check) {
  if (!frame.view().sensor || frame.cloud.size() > kMostPoints) return std::nullopt;
  Rays rays = gather_rays(frame, check);
  if (rays.size() > kMostRays) return std::nullopt;
  const auto slices = slices_of(rays);
  SweepSampling sampling;
  sampling.ring = ring_angle(slices);
  if (check.stopped() || sampling.ring < kNarrowestRings || sampling.ring > kWidestRings) return std::nullopt;
  sampling.azimuth = azimuth_angle(rays, sampling.ring);
  sampling.slope = slope_of(slices, sampling.ring);
  if (sampling.azimuth <= 0 || sampling.azimuth > kWidestRings || sampling.slope <= 0) return std::nullopt;
  const bool is_known = frame.options.preset == Preset::kLidar;
  if (is_known || (is_even(rays, sampling) && has_one_surface(slices, sampling))) return sampling;
  return std::nullopt;
}

}  // namespace segserve
