#include "core/normals/normal_orientation.hpp"

#include <cmath>
#include <functional>
#include <queue>
#include <tuple>
#include <utility>

#include "core/base/stop_check.hpp"
#include "core/normals/visibility.hpp"

namespace segserve {
namespace {

/// Hands sides on from voxel to voxel, always over the edge of the most parallel normals.
class Propagation {
 public:
  /// `known`: voxels whose normals have the right side.
  Propagation(const VoxelAdjacency& adjacency, const StopToken& stop, std::vector<bool> known,
              std::vector<Vec3>& normals)
      : adjacency_(adjacency), stop_(stop), check_(stop), normals_(normals), reached_(std::move(known)) {}

  /// From what is known to all that it is connected with.
  absl::Status spread_known() {
    for (std::uint32_t v = 0; v < normals_.size() && !check_.after(1); ++v) {
      if (reached_[v]) add_edges(v);
    }
    component_.clear();
    return drain();
  }

  /// Each component not reached yet starts from its smallest voxel, and is turned as a whole unless `keeps_side`.
  template <typename KeepsSide>
  absl::Status orient_the_rest(KeepsSide&& keeps_side) {
    for (std::uint32_t v = 0; v < normals_.size() && !check_.after(1); ++v) {
      if (reached_[v]) continue;
      component_.clear();
      reach(v);
      if (absl::Status status = drain(); !status.ok()) return status;
      if (keeps_side(component_, check_)) continue;
      check_.for_each(0, component_.size(),
                      [this](std::size_t i) { normals_[component_[i]] = -normals_[component_[i]]; });
    }
    return stop_.check();
  }

 private:
  struct Step {
    double cost;  // 1 - |cos| of the angle between the two normals
    std::uint32_t from, to;
    bool operator>(const Step& o) const { return std::tie(cost, from, to) > std::tie(o.cost, o.from, o.to); }
  };

  absl::Status drain() {
    while (!frontier_.empty()) {
      if (check_.after(1)) return stop_.check();
      const Step edge = frontier_.top();
      frontier_.pop();
      if (reached_[edge.to]) continue;
      if (dot(normals_[edge.from], normals_[edge.to]) < 0) normals_[edge.to] = -normals_[edge.to];
      reach(edge.to);
    }
    return absl::OkStatus();
  }

  void reach(std::uint32_t v) {
    reached_[v] = true;
    component_.push_back(v);
    add_edges(v);
  }

  void add_edges(std::uint32_t v) {
    check_.after(adjacency_.of(v).size());
    for (const std::uint32_t u : adjacency_.of(v)) {
      if (!reached_[u]) frontier_.push({1 - std::fabs(dot(normals_[v], normals_[u])), v, u});
    }
  }

  const VoxelAdjacency& adjacency_;
  const StopToken& stop_;
  StopCheck check_;
  std::vector<Vec3>& normals_;
  std::vector<bool> reached_;
  std::vector<std::uint32_t> component_;
  std::priority_queue<Step, std::vector<Step>, std::greater<>> frontier_;
};

}  // namespace

absl::Status orient_consistently(const VoxelAdjacency& adjacency, const StopToken& stop, std::vector<Vec3>& normals) {
  Propagation propagation(adjacency, stop, std::vector<bool>(normals.size(), false), normals);
  return propagation.orient_the_rest([&](const std::vector<std::uint32_t>& component, StopCheck& check) {
    Vec3 sum;
    check.for_each(0, component.size(), [&](std::size_t i) { sum += normals[component[i]]; });
    return std::tie(sum.z, sum.y, sum.x) >= std::make_tuple(0.0, 0.0, 0.0);
  });
}

absl::Status orient_hidden(const VoxelGrid& grid, const VoxelAdjacency& adjacency, const View& view,
                           double voxel_resolution, const StopToken& stop, std::vector<Vec3>& normals) {
  constexpr double kGrazing = 0.3;  // cosine below which a side says little
  const Vec3 sensor{(*view.sensor)[0], (*view.sensor)[1], (*view.sensor)[2]};
  const auto facing = [&](std::uint32_t v) { return dot(normals[v], unit(sensor - grid.centroid[v])); };
  const std::vector<bool> seen = seen_from(sensor, grid, voxel_resolution, stop);
  std::vector<bool> known(grid.size());
  StopCheck(stop).for_each(0, grid.size(), [&](std::size_t i) {
    const auto v = static_cast<std::uint32_t>(i);
    bool sure = seen[v] && facing(v) >= kGrazing;
    for (const std::uint32_t u : adjacency.of(v)) sure = sure && seen[u];
    known[v] = sure;
    return 1 + adjacency.of(v).size();
  });
  if (absl::Status status = stop.check(); !status.ok()) return status;
  Propagation propagation(adjacency, stop, std::move(known), normals);
  if (absl::Status status = propagation.spread_known(); !status.ok()) return status;
  return propagation.orient_the_rest([&](const std::vector<std::uint32_t>& component, StopCheck& check) {
    double sum = 0;
    check.for_each(0, component.size(), [&](std::size_t i) { sum += facing(component[i]); });
    return sum >= 0;
  });
}

}  // namespace segserve
