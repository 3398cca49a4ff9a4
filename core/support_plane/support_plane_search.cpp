// SPDX-License-Identifier: Apache-2.0
#include "core/support_plane/support_plane_search.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>

#include "core/base/stop_check.hpp"
#include "core/math/eigen_conversion.hpp"
#include "core/math/random.hpp"
#include "core/math/symmetric_matrix3.hpp"

namespace segserve {
namespace {

constexpr double kSmallestShare = 0.1;  // of all voxels that a plane must hold
constexpr double kUp = 0.8660254;       // cosine of 30 degrees
constexpr double kUpright = 0.17;       // sine of 10 degrees: a camera that looks up by less takes no wall for a table
constexpr double kRoll = 0.5;           // sine of 30 degrees
constexpr double kAgree = 0.8660254;    // cosine of 30 degrees between the normals of a voxel and its plane
constexpr double kFringe = 0.5;         // of the distance, within which voxels beside the plane belong to it
constexpr int kFringeSteps = 2;         // as many as the rings of neighbors to which normals are fitted
constexpr std::uint32_t kSamples = 2048;
constexpr std::uint32_t kGuesses = 64;
constexpr int kRefinedGuesses = 8;
// How thick the plane is in the successive fits, in distances. The first fits look farther, because the plane of a
// single voxel is off by degrees.
constexpr double kWidening[] = {4, 2, 1, 1};

struct Plane {
  Vec3 normal;
  double offset = 0;
};

class SupportPlaneSearch {
 public:
  SupportPlaneSearch(const FrameContext& frame, const VoxelGrid& grid, const std::vector<Vec3>& normals,
                     StopCheck& check)
      : grid_(grid),
        normals_(normals),
        view_(frame.view()),
        distance_(*frame.options.support_plane_distance),
        check_(check),
        all_(grid.size()) {
    check_.for_each(0, all_.size(), [this](std::size_t v) { all_[v] = static_cast<std::uint32_t>(v); });
    Random random(1);
    for (std::uint32_t i = 0; i < kSamples; ++i)
      samples_.push_back(random.below(static_cast<std::uint32_t>(all_.size())));
  }

  /// The plane of most voxels, however few they are.
  std::optional<Plane> find() const {
    std::vector<Guess> guesses = guess();
    std::optional<Plane> best;
    std::size_t highest_rank = 0;
    for (int turn = 0; turn < kRefinedGuesses && !guesses.empty() && !check_.after(guesses.size()); ++turn) {
      const std::uint32_t origin = std::ranges::max_element(guesses, {}, &Guess::rank)->voxel;
      const std::optional<Plane> plane = fit(plane_at(origin), samples_, kWidening);
      if (const std::size_t rank = plane ? this->rank(*plane, 1) : 0; rank > highest_rank) {
        highest_rank = rank;
        best = plane;
      }
      std::erase_if(guesses, [&](const Guess& g) { return g.voxel == origin || (plane && holds(*plane, g.voxel, 1)); });
    }
    return best ? fit(*best, all_, std::span(kWidening).last(2)) : best;
  }

  /// Whether the voxel lies in the plane and its normal agrees. The plane is `widening` times as thick as asked for.
  bool holds(const Plane& plane, std::uint32_t v, double widening) const {
    return near(plane, v, widening) && agreement(plane.normal, normals_[v]) >= kAgree;
  }

  /// Whether the voxel is at most `factor` distances away from the plane.
  bool near(const Plane& plane, std::uint32_t v, double factor) const {
    const double scale = view_.kind == ViewKind::kCamera ? grid_.centroid[v].z : 1;
    return std::fabs(dot(plane.normal, grid_.centroid[v]) - plane.offset) <= factor * distance_ * scale;
  }

 private:
  struct Guess {
    std::uint32_t voxel;
    std::size_t rank;
  };

  /// The planes of random voxels and their normals.
  std::vector<Guess> guess() const {
    std::vector<Guess> guesses;
    for (std::uint32_t i = 0; i < kGuesses && !check_.stopped(); ++i) {
      const std::uint32_t v = samples_[i];
      const Plane plane = plane_at(v);
      if (may_support(plane.normal)) guesses.push_back({v, rank(plane, kWidening[0])});
    }
    return guesses;
  }

  Plane plane_at(std::uint32_t v) const { return {upward(normals_[v]), dot(upward(normals_[v]), grid_.centroid[v])}; }

  /// Without a sensor it is not known which side is the outer one.
  Vec3 upward(const Vec3& normal) const { return !view_.has_sensor() && normal.z < 0 ? -normal : normal; }
  double agreement(const Vec3& a, const Vec3& b) const { return view_.has_sensor() ? dot(a, b) : std::fabs(dot(a, b)); }
  bool may_support(const Vec3& normal) const {
    return view_.kind == ViewKind::kCamera ? normal != Vec3{} : normal.z >= kUp;
  }

  /// Whether the plane faces up in the frame of an upright camera, with y down.
  bool faces_up_before_upright_camera(const Vec3& normal) const {
    return view_.kind == ViewKind::kCamera && normal.y <= -kUpright && std::fabs(normal.x) <= kRoll;
  }

  /// The number of samples in the plane; planes that are preferred rank above all others.
  std::size_t rank(const Plane& plane, double widening) const {
    if (check_.after(samples_.size())) return 0;
    const auto held = static_cast<std::size_t>(
        std::ranges::count_if(samples_, [&](std::uint32_t v) { return holds(plane, v, widening); }));
    const bool preferred = faces_up_before_upright_camera(plane.normal) &&
                           static_cast<double>(held) >= kSmallestShare * static_cast<double>(kSamples);
    return preferred ? kSamples + held : held;
  }

  /// Fits the plane to those of the voxels that it holds, once for each widening.
  std::optional<Plane> fit(Plane plane, std::span<const std::uint32_t> voxels,
                           std::span<const double> widenings) const {
    for (const double widening : widenings) {
      double total = 0;
      Vec3 sum;
      Symmetric3 square;
      const Vec3 origin = grid_.centroid[0];  // An origin within the cloud keeps the moments exact.
      check_.for_each(0, voxels.size(), [&](std::size_t i) {
        const std::uint32_t v = voxels[i];
        if (!holds(plane, v, widening)) return;
        const Vec3 p = grid_.centroid[v] - origin;
        total += 1, sum += p, square += outer(p);
      });
      if (total < 3) return std::nullopt;
      square += (-1 / total) * outer(sum);
      const Vec3 normal = smallest_eigenvector(square);
      if (normal == Vec3{}) return std::nullopt;
      plane.normal = dot(normal, plane.normal) < 0 ? -normal : normal;
      plane.offset = dot(plane.normal, origin + (1 / total) * sum);
    }
    return may_support(plane.normal) ? std::optional(plane) : std::nullopt;
  }

  const VoxelGrid& grid_;
  const std::vector<Vec3>& normals_;
  const View& view_;
  double distance_;
  StopCheck& check_;
  std::vector<std::uint32_t> all_;      // V: all voxels
  std::vector<std::uint32_t> samples_;  // kSamples of them
};

/// Adds voxels beside members, where normals reach across edges.
void add_fringe(const SupportPlaneSearch& search, const Plane& plane, const VoxelAdjacency& adjacency, StopCheck& check,
                std::vector<bool>& member) {
  std::vector<std::uint32_t> border;
  check.for_each(0, member.size(), [&](std::size_t v) {
    if (member[v]) border.push_back(static_cast<std::uint32_t>(v));
  });
  for (int step = 0; step < kFringeSteps; ++step) {
    std::vector<std::uint32_t> added;
    for (const std::uint32_t v : border) {
      if (check.after(1 + adjacency.of(v).size())) return;
      for (const std::uint32_t u : adjacency.of(v)) {
        if (member[u] || !search.near(plane, u, kFringe)) continue;
        member[u] = true;
        added.push_back(u);
      }
    }
    border = std::move(added);
  }
}

}  // namespace

absl::Status find_support_plane(const FrameContext& frame, const VoxelGrid& grid, const VoxelAdjacency& adjacency,
                                const std::vector<Vec3>& normals, PlaneVoxels& found) {
  StopCheck check(frame.stop);
  found.plane = {};
  found.member.assign(grid.size(), false);
  if (grid.size() == 0) return check.status();
  const SupportPlaneSearch search(frame, grid, normals, check);
  const std::optional<Plane> plane = search.find();
  if (!plane) return check.status();
  std::size_t members = 0;
  check.for_each(0, grid.size(), [&](std::size_t v) {
    found.member[v] = search.holds(*plane, static_cast<std::uint32_t>(v), 1);
    members += static_cast<std::size_t>(found.member[v]);
  });
  if (static_cast<double>(members) < kSmallestShare * static_cast<double>(grid.size())) {
    found.member.assign(grid.size(), false);
    return check.status();
  }
  found.plane = {.normal = to_eigen(plane->normal), .offset = plane->offset};
  add_fringe(search, *plane, adjacency, check, found.member);
  check.for_each(0, grid.size(), [&](std::size_t v) {
    if (found.member[v]) found.plane.points += grid.points[v];
  });
  return check.status();
}

}  // namespace segserve
