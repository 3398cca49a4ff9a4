// SPDX-License-Identifier: Apache-2.0
#include "core/normals/normal_orientation.hpp"

#include <algorithm>
#include <functional>
#include <limits>
#include <queue>
#include <tuple>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
#include "core/math/eigen_conversion.hpp"
#include "core/normals/visibility.hpp"

namespace segserve {
namespace {

/// Hands the sides of normals on from voxel to voxel, always over the edge of the most parallel normals.
class Propagation {
 public:
  /// `known` tells which normals have the right side.
  Propagation(const VoxelAdjacency& adjacency, std::vector<bool> known, StopCheck& check, std::vector<Vec3>& normals)
      : adjacency_(adjacency),
        check_(check),
        normals_(normals),
        reached_(std::move(known)),
        best_(normals.size(), {std::numeric_limits<double>::infinity(), 0}) {}

  /// Hands the known sides on to all voxels that are connected with them.
  void spread_known() {
    for (std::uint32_t v = 0; v < normals_.size() && !check_.after(1); ++v) {
      if (reached_[v]) add_edges(v);
    }
    component_.clear();
    empty_frontier();
  }

  /// Makes each component that is not reached yet consistent, from its smallest voxel on, and turns it as a whole
  /// unless keeps_side(component).
  template <typename KeepsSide>
  void orient_the_rest(KeepsSide&& keeps_side) {
    for (std::uint32_t v = 0; v < normals_.size() && !check_.after(1); ++v) {
      if (reached_[v]) continue;
      component_.clear();
      reach(v);
      empty_frontier();
      if (keeps_side(component_)) continue;
      check_.for_each(0, component_.size(),
                      [this](std::size_t i) { normals_[component_[i]] = -normals_[component_[i]]; });
    }
  }

 private:
  struct Step {
    double cost;  // 1 - |cos| of the angle between the two normals
    std::uint32_t from, to;
    bool operator>(const Step& o) const { return std::tie(cost, from, to) > std::tie(o.cost, o.from, o.to); }
  };
  struct Arrival {
    double cost;
    std::uint32_t from;
    bool operator<(const Arrival& o) const { return std::tie(cost, from) < std::tie(o.cost, o.from); }
  };

  void empty_frontier() {
    while (!frontier_.empty() && !check_.after(1)) {
      const Step edge = frontier_.top();
      frontier_.pop();
      if (reached_[edge.to]) continue;
      if (dot(normals_[edge.from], normals_[edge.to]) < 0) normals_[edge.to] = -normals_[edge.to];
      reach(edge.to);
    }
  }

  void reach(std::uint32_t v) {
    reached_[v] = true;
    component_.push_back(v);
    add_edges(v);
  }

  void add_edges(std::uint32_t v) {
    check_.after(adjacency_.of(v).size());
    for (const std::uint32_t u : adjacency_.of(v)) {
      if (reached_[u]) continue;
      const Arrival arrival{1 - std::fabs(dot(normals_[v], normals_[u])), v};
      if (!(arrival < best_[u])) continue;  // u would be reached before it is this step's turn.
      best_[u] = arrival;
      frontier_.push({arrival.cost, v, u});
    }
  }

  const VoxelAdjacency& adjacency_;
  StopCheck& check_;
  std::vector<Vec3>& normals_;
  std::vector<bool> reached_;
  std::vector<Arrival> best_;  // of the steps to each voxel so far
  std::vector<std::uint32_t> component_;
  std::priority_queue<Step, std::vector<Step>, std::greater<>> frontier_;
};

Vec3 sum_of(const std::vector<Vec3>& normals, const std::vector<std::uint32_t>& component, StopCheck& check) {
  Vec3 sum;
  check.for_each(0, component.size(), [&](std::size_t i) { sum += normals[component[i]]; });
  return sum;
}

bool points_upwards(const Vec3& sum) { return std::tie(sum.z, sum.y, sum.x) >= std::make_tuple(0.0, 0.0, 0.0); }

/// Whether floor and ceiling, or top and bottom, cancel one another, so that the sum of the normals tells no side.
bool is_closed(const std::vector<std::uint32_t>& component, const Vec3& sum_of_normals) {
  constexpr std::size_t kFewest = 100;
  constexpr double kShare = 0.1;
  return component.size() >= kFewest && std::fabs(sum_of_normals.z) < kShare * static_cast<double>(component.size());
}

/// Whether a thing with this diagonal, meters, is seen from the inside.
bool is_room(double diagonal, Preset preset) {
  constexpr double kSmallest = 2.5;
  return preset == Preset::kRoom || (preset != Preset::kScan && diagonal > kSmallest);
}

/// Whether the normals of a closed component point to where it is seen from: the inside of a room, the outside of a
/// thing.
bool faces_where_it_is_seen(const VoxelGrid& grid, Preset preset, const std::vector<Vec3>& normals,
                            const std::vector<std::uint32_t>& component, StopCheck& check) {
  Vec3 low = grid.centroid[component[0]], high = low;
  check.for_each(0, component.size(), [&](std::size_t i) {
    const Vec3& p = grid.centroid[component[i]];
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  });
  const Vec3 middle = 0.5 * (low + high);
  double outwards = 0;
  check.for_each(0, component.size(),
                 [&](std::size_t i) { outwards += dot(grid.centroid[component[i]] - middle, normals[component[i]]); });
  return (outwards > 0) != is_room(norm(high - low), preset);
}

}  // namespace

Vec3 sensor_of(const View& view) {
  return view.sensor ? Vec3{(*view.sensor)[0], (*view.sensor)[1], (*view.sensor)[2]} : Vec3{};
}

void turn_to_sensors(const FrameContext& frame, const VoxelGrid& grid, std::size_t first, std::size_t last,
                     std::vector<Vec3>& normals) {
  const View& view = frame.view();
  if (!view.has_sensor()) return;
  if (view.cameras.empty()) {
    const Vec3 sensor = sensor_of(view);
    for (std::size_t v = first; v < last; ++v) normals[v] = turn_to_sensor(normals[v], grid.centroid[v], sensor);
    return;
  }
  for (std::size_t v = first; v < last; ++v) {
    const Vec3 sensor = to_vec3(view.cameras[grid.camera[v]].sensor.cast<double>());
    normals[v] = turn_to_sensor(normals[v], grid.centroid[v], sensor);
  }
}

absl::Status orient_upwards(const FrameContext& frame, const VoxelAdjacency& adjacency, std::vector<Vec3>& normals) {
  StopCheck check(frame.stop);
  Propagation propagation(adjacency, std::vector<bool>(normals.size(), false), check, normals);
  propagation.orient_the_rest(
      [&](const std::vector<std::uint32_t>& component) { return points_upwards(sum_of(normals, component, check)); });
  return check.status();
}

absl::Status orient_as_seen(const FrameContext& frame, const VoxelGrid& grid, const VoxelAdjacency& adjacency,
                            std::vector<Vec3>& normals) {
  StopCheck check(frame.stop);
  Propagation propagation(adjacency, std::vector<bool>(normals.size(), false), check, normals);
  propagation.orient_the_rest([&](const std::vector<std::uint32_t>& component) {
    const Vec3 sum = sum_of(normals, component, check);
    return is_closed(component, sum) ? faces_where_it_is_seen(grid, frame.options.preset, normals, component, check)
                                     : points_upwards(sum);
  });
  return check.status();
}

absl::Status orient_hidden_normals(const FrameContext& frame, const VoxelGrid& grid, const VoxelAdjacency& adjacency,
                                   std::vector<Vec3>& normals) {
  constexpr double kGrazing = 0.3;  // cosine below which the side that faces the sensor says little
  const Vec3 sensor = sensor_of(frame.view());
  const auto facing = [&](std::uint32_t v) { return dot(normals[v], unit(sensor - grid.centroid[v])); };
  std::vector<bool> visible;
  RETURN_IF_ERROR(find_visible_voxels(frame, grid, visible));
  StopCheck check(frame.stop);
  std::vector<bool> known(grid.size());
  check.for_each(0, grid.size(), [&](std::size_t i) {
    const auto v = static_cast<std::uint32_t>(i);
    bool sure = visible[v] && facing(v) >= kGrazing;
    for (const std::uint32_t u : adjacency.of(v)) sure = sure && visible[u];
    known[v] = sure;
    return 1 + adjacency.of(v).size();
  });
  Propagation propagation(adjacency, std::move(known), check, normals);
  propagation.spread_known();
  propagation.orient_the_rest([&](const std::vector<std::uint32_t>& component) {
    double sum = 0;
    check.for_each(0, component.size(), [&](std::size_t i) { sum += facing(component[i]); });
    return sum >= 0;
  });
  return check.status();
}

}  // namespace segserve
