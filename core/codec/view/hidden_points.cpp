// SPDX-License-Identifier: Apache-2.0
#include "core/codec/view/hidden_points.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/codec/view/view_points.hpp"

namespace segserve::codec {
namespace {

/// Where a point is as seen from the origin. Directions are the cells of the six faces of a cube.
struct Place {
  std::uint32_t cell;
  float range;
};

/// The place of a point; faces have edge * edge cells, and `edge` is at most 4096.
Place place_of(const CloudView& cloud, std::size_t i, int edge) {
  const std::array<float, 3> p{cloud.x[i], cloud.y[i], cloud.z[i]};
  std::size_t main = 0;
  for (std::size_t axis = 1; axis < 3; ++axis) main = std::abs(p[axis]) > std::abs(p[main]) ? axis : main;
  const auto step = [&](float across) {
    const float along = (across / std::abs(p[main]) + 1) * 0.5F * static_cast<float>(edge);
    return static_cast<std::uint32_t>(std::clamp(static_cast<int>(along), 0, edge - 1));
  };
  const auto face = static_cast<std::uint32_t>(2 * main + (p[main] < 0 ? 1 : 0));
  const std::uint32_t row = step(p[(main + 1) % 3]), column = step(p[(main + 2) % 3]);
  const auto cells = static_cast<std::uint32_t>(edge);
  return {(face * cells + row) * cells + column, std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2])};
}

constexpr std::size_t kPointsOfCell = 12;  // in the mean, so that the nearest surface has one of them

/// The nearest points of all directions.
class NearestPoints {
 public:
  explicit NearestPoints(int edge) : edge_(edge), cells_(std::size_t{6} * edge * edge) {}

  void add(const CloudView& cloud, std::size_t i) {
    const auto [cell, range] = place_of(cloud, i, edge_);
    occupied_ += cells_[cell].points == 0 ? 1U : 0U;
    ++cells_[cell].points;
    cells_[cell].nearest = std::min(cells_[cell].nearest, range);
  }
  std::size_t occupied() const { return occupied_; }
  /// Whether a point lies far behind the nearest one in its direction; nullopt where there are too few of them.
  std::optional<bool> is_hidden(const CloudView& cloud, std::size_t i) const {
    constexpr std::size_t kFewestPoints = 4;
    constexpr float kBehind = 1.5F;  // A surface that is seen at a small angle does not reach so far within a cell.
    const auto [cell, range] = place_of(cloud, i, edge_);
    if (cells_[cell].points < kFewestPoints) return std::nullopt;
    return range > kBehind * cells_[cell].nearest;
  }

 private:
  struct Cell {
    std::size_t points = 0;
    float nearest = HUGE_VALF;
  };

  const int edge_;
  std::vector<Cell> cells_;
  std::size_t occupied_ = 0;
};

/// The places of a sample of the points, ordered by cell and range. The cells are the finest that hold enough points in
/// the mean. Returns the edge of the faces, or 0 if even coarse cells hold too few.
int find_places(const CloudView& cloud, StopCheck& check, std::vector<Place>& places) {
  constexpr int kFinest = 4096, kCoarsest = 8;
  std::vector<std::size_t> points;
  for_each_of_sample(cloud, check, [&](std::size_t i) { points.push_back(i); });
  for (int edge = kFinest; edge >= kCoarsest && !check.after(16 * points.size()); edge /= 2) {
    places.clear();
    for (const std::size_t i : points) places.push_back(place_of(cloud, i, edge));
    std::ranges::sort(
        places, [](const Place& a, const Place& b) { return std::pair(a.cell, a.range) < std::pair(b.cell, b.range); });
    std::size_t cells = 0;
    for (std::size_t i = 0; i < places.size(); ++i) cells += i == 0 || places[i].cell != places[i - 1].cell ? 1 : 0;
    if (places.size() >= kPointsOfCell * cells) return edge;
  }
  return 0;
}

/// How many points of a cell, which are ordered by their range, lie in a second layer: behind a gap that is wider than
/// either side of it is deep, and much wider than the cell. The rows of points on a surface that is seen at a small
/// angle have no such gaps.
std::size_t points_in_second_layer(std::span<const Place> cell, int edge) {
  constexpr float kCells = 3;
  std::size_t behind = 1;  // the first one behind the widest gap
  for (std::size_t i = 1; i < cell.size(); ++i) {
    if (cell[i].range - cell[i - 1].range > cell[behind].range - cell[behind - 1].range) behind = i;
  }
  const float gap = cell[behind].range - cell[behind - 1].range;
  const float depth = std::max(cell[behind - 1].range - cell.front().range, cell.back().range - cell[behind].range);
  const float width = cell.front().range * 2 / static_cast<float>(edge);
  return gap > std::max(depth, kCells * width) ? cell.size() - behind : 0;
}

}  // namespace

bool hide_one_another(const CloudView& cloud, StopCheck& check) {
  constexpr int kFinest = 256, kCoarsest = 8;
  constexpr double kShare = 0.1;
  for (int edge = kFinest; edge >= kCoarsest; edge /= 2) {
    NearestPoints nearest(edge);
    std::size_t points = 0, known = 0, hidden = 0;
    check.for_each(0, cloud.size(), [&](std::size_t i) {
      if (!is_point(cloud, i)) return;
      nearest.add(cloud, i);
      ++points;
    });
    if (points < kPointsOfCell * nearest.occupied()) continue;
    check.for_each(0, cloud.size(), [&](std::size_t i) {
      if (!is_point(cloud, i)) return;
      const auto is_hidden = nearest.is_hidden(cloud, i);
      known += is_hidden ? 1U : 0U;
      hidden += is_hidden.value_or(false) ? 1U : 0U;
    });
    return static_cast<double>(hidden) > kShare * static_cast<double>(known);
  }
  return false;
}

bool lie_in_layers(const CloudView& cloud, StopCheck& check) {
  constexpr std::size_t kFewestPoints = 4;
  constexpr double kShare = 0.1;
  std::vector<Place> places;
  const int edge = find_places(cloud, check, places);
  if (edge == 0) return false;
  std::size_t known = 0, hidden = 0;
  for (std::size_t begin = 0, end = 0; begin < places.size(); begin = end) {
    while (end < places.size() && places[end].cell == places[begin].cell) ++end;
    if (end - begin < kFewestPoints) continue;
    known += end - begin;
    hidden += points_in_second_layer(std::span(places).subspan(begin, end - begin), edge);
  }
  return static_cast<double>(hidden) > kShare * static_cast<double>(known);
}

}  // namespace segserve::codec
