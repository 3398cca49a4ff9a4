// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/surface_grid.hpp"

#include <bit>
#include <cmath>

#include "core/math/random.hpp"

namespace segserve::synth {

SurfaceGrid::SurfaceGrid(double spacing, const Vec3& origin, std::size_t expected_cells)
    : inverse_spacing_(1 / spacing), origin_(origin), slots_(std::bit_ceil(expected_cells + expected_cells / 2 + 16)) {
  cells_.reserve(expected_cells);
}

SurfaceGrid::Cell& SurfaceGrid::find_or_add(const Vec3& surface_point) {
  const Vec3 p = inverse_spacing_ * (surface_point - origin_);
  const auto coordinate = [](double value) {
    constexpr std::int64_t kMiddle = 1 << 20;
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(value)) + kMiddle) & 0x1FFFFFU;
  };
  const std::uint64_t key = coordinate(p.x) << 42U | coordinate(p.y) << 21U | coordinate(p.z);
  std::size_t slot = mix(key) & (slots_.size() - 1);
  while (slots_[slot] != 0) {
    Cell& found = cells_[slots_[slot] - 1];
    if (found.key == key) return found;
    slot = (slot + 1) & (slots_.size() - 1);
  }
  cells_.push_back({key, 0, 0, 0, 0, 0, 0});
  slots_[slot] = static_cast<std::uint32_t>(cells_.size());
  if (cells_.size() * 4 > slots_.size() * 3) grow();
  return cells_.back();
}

void SurfaceGrid::grow() {
  slots_.assign(2 * slots_.size(), 0);
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    std::size_t slot = mix(cells_[i].key) & (slots_.size() - 1);
    while (slots_[slot] != 0) slot = (slot + 1) & (slots_.size() - 1);
    slots_[slot] = static_cast<std::uint32_t>(i + 1);
  }
}

void SurfaceGrid::add(Cell& cell, const Vec3& measured, double weight) const {
  const Vec3 p = measured - origin_;
  cell.x += static_cast<float>(weight * p.x);
  cell.y += static_cast<float>(weight * p.y);
  cell.z += static_cast<float>(weight * p.z);
  cell.weight += static_cast<float>(weight);
}

Vec3 SurfaceGrid::position(const Cell& cell) const {
  const double w = cell.weight;
  return origin_ + Vec3{cell.x / w, cell.y / w, cell.z / w};
}

}  // namespace segserve::synth
