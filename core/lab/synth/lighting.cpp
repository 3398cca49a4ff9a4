// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/lighting.hpp"

#include <algorithm>
#include <cmath>

namespace segserve::synth {
namespace {
constexpr std::uint32_t kMapSize = 384;  // pixels
constexpr int kSoftness = 3;             // pixels on each side of the neighborhood that is compared
}  // namespace

ShadowMap::ShadowMap(const World& world, const Vec3& from, const Vec3& to, double radius)
    : camera_(look_at(from, to, kMapSize / 2.0 * norm(to - from) / radius, kMapSize, kMapSize)),
      depth_(std::size_t{kMapSize} * kMapSize) {
  const RayCaster caster(world, camera_);
  for (std::uint32_t v = 0, i = 0; v < kMapSize; ++v) {
    for (std::uint32_t u = 0; u < kMapSize; ++u, ++i) depth_[i] = static_cast<float>(caster.cast(u, v).depth);
  }
}

double ShadowMap::lit_share(const Vec3& point, const Vec3& normal) const {
  // A texel covers a patch of the surface. The point is moved outwards by more than that, so that the surface does not
  // shade itself.
  const double distance = camera_.pose.to_local(point).z;
  const Vec3 p = camera_.pose.to_local(point + (1.6 * distance / camera_.focal) * normal);
  if (p.z <= 0) return 1;
  const double u = camera_.center_u + camera_.focal * p.x / p.z;
  const double v = camera_.center_v + camera_.focal * p.y / p.z;
  constexpr double kLast = kMapSize - 1.0 - kSoftness - 1;
  if (!(u > kSoftness && v > kSoftness && u < kLast && v < kLast)) return 1;
  const auto i = static_cast<int>(u);
  const auto j = static_cast<int>(v);
  const auto depth = static_cast<float>(p.z * (1 - 0.6 / camera_.focal));
  const double fu = u - i;
  const double fv = v - j;
  // A box filter. Texels on its border count by the share that the box covers, so that shadows have no steps.
  double sum = 0;
  for (int dj = -kSoftness; dj <= kSoftness + 1; ++dj) {
    const double wv = dj == -kSoftness ? 1 - fv : dj == kSoftness + 1 ? fv : 1;
    const float* row = depth_.data() + static_cast<std::size_t>(j + dj) * kMapSize + static_cast<std::size_t>(i);
    double across = 0;
    for (int di = -kSoftness + 1; di <= kSoftness; ++di) across += row[di] > depth ? 1 : 0;
    across += row[-kSoftness] > depth ? 1 - fu : 0;
    across += row[kSoftness + 1] > depth ? fu : 0;
    sum += wv * across;
  }
  constexpr double kArea = (2 * kSoftness + 1.0) * (2 * kSoftness + 1.0);
  return sum / kArea;
}

Vec3 Lighting::shade(const Vec3& color, const Vec3& normal, double lit) const {
  const double sky = ambient * (0.7 + 0.3 * normal.z) * (0.75 + 0.25 * lit);
  const double light = sky + key * lit * std::max(0.0, dot(normal, lamp)) + fill * std::max(0.0, dot(normal, window));
  return std::sqrt(light) * color;
}

}  // namespace segserve::synth
