// SPDX-License-Identifier: Apache-2.0
//
// The voxels and clusters of supervoxel growth, for this folder alone.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/math/vec3.hpp"
#include "core/supervoxels/simd/growth_kernels.hpp"

namespace segserve::growth {

inline constexpr std::uint32_t kNoCluster = std::numeric_limits<std::uint32_t>::max();
inline constexpr float kUnreached =
    std::numeric_limits<float>::infinity();  ///< the distance of a voxel without cluster

/// `position` and `color` are scaled by their weights; `normal` is a unit vector or 0.
inline Feature make_feature(const Vec3& position, const Vec3& color, const Vec3& normal) {
  const auto f = [](double v) { return static_cast<float>(v); };
  return {{f(position.x), f(position.y), f(position.z), f(normal.x), f(normal.y), f(normal.z), f(color.x), f(color.y),
           f(color.z)}};
}

/// The distance between two features, measured as in the kernel assign_candidates.
inline float distance_between(const DistanceWeights& weights, const Feature& a, const Feature& b) {
  const auto difference = [&](Feature::Index i) { return a.value[i] - b.value[i]; };
  const auto product = [&](Feature::Index i) { return a.value[i] * b.value[i]; };
  const float x = difference(Feature::kX), y = difference(Feature::kY), z = difference(Feature::kZ);
  const float red = difference(Feature::kRed), green = difference(Feature::kGreen), blue = difference(Feature::kBlue);
  const float cosine = product(Feature::kNormalX) + product(Feature::kNormalY) + product(Feature::kNormalZ);
  return std::sqrt(x * x + y * y + z * z) + std::sqrt(red * red + green * green + blue * blue) +
         weights.normal * (1.0F - std::fabs(cosine));
}

/// The sum of the features of a cluster's voxels.
class FeatureSum {
 public:
  void add(const Feature& feature) {
    for (std::size_t i = 0; i < Feature::kSize; ++i) sum_[i] += static_cast<double>(feature.value[i]);
  }
  void subtract(const Feature& feature) {
    for (std::size_t i = 0; i < Feature::kSize; ++i) sum_[i] -= static_cast<double>(feature.value[i]);
  }
  /// The mean of `count` features. Its normal is the unit vector along the sum of theirs.
  Feature mean(std::size_t count) const {
    const auto vector = [&](Feature::Index first) { return Vec3{sum_[first], sum_[first + 1], sum_[first + 2]}; };
    const double scale = 1 / static_cast<double>(count);
    return make_feature(scale * vector(Feature::kX), scale * vector(Feature::kRed), unit(vector(Feature::kNormalX)));
  }

 private:
  double sum_[Feature::kSize] = {};
};

/// A supervoxel that grows.
struct Cluster {
  /// Every voxel outside the cluster that has a neighbor in it, once, and some voxels that had one and lost it. An
  /// expansion looks at these alone, not at the neighbors of all voxels of the cluster.
  std::vector<std::uint32_t> candidates;
  std::size_t count = 0;  ///< of its voxels
  FeatureSum sum;
  Feature center{};
  // A cluster that neither gained nor lost a voxel since its last expansion would gain none by the next.
  bool active = true;            ///< it gained or lost a voxel since its last expansion
  bool active_next = false;      ///< the same for the next iteration
  bool has_lost_voxels = false;  ///< as long as it has not, all candidates have a neighbor in it

  bool can_expand() const { return active && count > 0; }

  /// Voxel v, which has this feature, goes to another cluster.
  void lose(std::uint32_t v, const Feature& feature) {
    --count;
    sum.subtract(feature);
    candidates.push_back(v);
    active = active_next = has_lost_voxels = true;
  }
  /// Makes it a new cluster without voxels. The candidates keep their memory.
  void clear() {
    candidates.clear();
    count = 0;
    sum = {};
    active = true;
    active_next = false;
    has_lost_voxels = false;
  }
};

/// A voxel of a layer (UnreachedVoxelAssigner) and the cluster that it is assigned to.
struct LayerVoxel {
  std::uint32_t voxel, cluster;
};

/// It is kept between frames for its memory.
struct GrowthState {
  std::vector<Voxel> voxels;       ///< V
  std::size_t most_neighbors = 0;  ///< of any voxel
  std::uint32_t expansion_count = 0;
  std::uint32_t cluster_count = 0;
  std::vector<Cluster> clusters;  ///< `cluster_count` of them are in use; the others keep the memory of candidates
  // Buffers:
  std::vector<AssignedVoxel> assigned;        ///< by an expansion
  std::vector<std::uint32_t> new_candidates;  ///< of an expansion
  std::vector<std::uint32_t> unreached;       ///< voxels that the iterations did not reach
  std::vector<LayerVoxel> layers;             ///< of unreached voxels
  std::vector<std::uint32_t> supervoxel_of_cluster;

  void clear(std::size_t voxel_count) {
    voxels.resize(voxel_count);
    most_neighbors = 0;
    expansion_count = cluster_count = 0;
  }
  std::uint32_t add_cluster() {
    if (cluster_count == clusters.size()) clusters.emplace_back();
    clusters[cluster_count].clear();
    return cluster_count++;
  }
};

}  // namespace segserve::growth
