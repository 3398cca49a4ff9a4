#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/math/vec3.hpp"
#include "core/supervoxels/simd/growth_kernels.hpp"

// What growth keeps of voxels and clusters: of this folder alone.

namespace segserve::growth {

inline constexpr std::uint32_t kNobody = std::numeric_limits<std::uint32_t>::max();
inline constexpr float kUnreached = std::numeric_limits<float>::infinity();

/// From a position, colour and normal that are scaled by the weights.
inline Feature feature(const Vec3& position, const Vec3& color, const Vec3& normal) {
  const auto f = [](double v) { return static_cast<float>(v); };
  return {f(position.x), f(position.y), f(position.z), f(normal.x), f(normal.y),
          f(normal.z),   f(color.x),    f(color.y),    f(color.z)};
}

/// The distance between two features, as the kernel find_claims measures it.
inline float distance_between(const Distance& distance, const Feature& a, const Feature& b) {
  const float px = a.px - b.px, py = a.py - b.py, pz = a.pz - b.pz;
  const float cr = a.cr - b.cr, cg = a.cg - b.cg, cb = a.cb - b.cb;
  const float cosine = a.nx * b.nx + a.ny * b.ny + a.nz * b.nz;
  return std::sqrt(px * px + py * py + pz * pz) + std::sqrt(cr * cr + cg * cg + cb * cb) +
         distance.normal_weight * (1.0F - std::fabs(cosine));
}

/// Of features, number by number: two at a time are half the instructions, as the compiler sees by itself only where
/// they are an array.
class FeatureSum {
 public:
  void add(const Feature& f) {
    for (std::size_t i = 0; i < kNumbers; ++i) sum_[i] += static_cast<double>((&f.px)[i]);
  }
  void take_off(const Feature& f) {
    for (std::size_t i = 0; i < kNumbers; ++i) sum_[i] -= static_cast<double>((&f.px)[i]);
  }
  Feature mean(std::size_t count) const {
    const double scale = 1 / static_cast<double>(count);
    const auto& [px, py, pz, nx, ny, nz, cr, cg, cb] = sum_;
    return feature(scale * Vec3{px, py, pz}, scale * Vec3{cr, cg, cb}, unit(Vec3{nx, ny, nz}));
  }

 private:
  static constexpr std::size_t kNumbers = sizeof(Feature) / sizeof(float);
  double sum_[kNumbers] = {};
};

struct Cluster {
  /// All foreign voxels that touch it, each once, and some that did and no longer do. A turn looks at these alone, not
  /// at the neighbours of all its voxels: a fifth of the visits.
  std::vector<std::uint32_t> candidates;
  std::size_t count = 0;  // voxels it owns
  FeatureSum sum;
  Feature centre{};
  // Nothing changes at the turn of a cluster that neither gained nor lost since its last one.
  bool changed = true;
  bool changed_next = false;
  bool lost = false;  // a voxel, ever: until then all candidates touch it

  bool takes_turn() const { return changed && count > 0; }

  /// Voxel v, whose feature is given, goes to another cluster.
  void lose(std::uint32_t v, const Feature& feature) {
    --count;
    sum.take_off(feature);
    candidates.push_back(v);
    changed = changed_next = lost = true;
  }
  /// As new, but the candidates keep their memory.
  void clear() {
    candidates.clear();
    count = 0;
    sum = {};
    changed = true;
    changed_next = false;
    lost = false;
  }
};

/// A voxel that is about to become that of a cluster.
struct Assignment {
  std::uint32_t voxel, cluster;
};

/// Kept between calls for its memory.
struct State {
  std::vector<Voxel> voxels;       // V
  std::size_t most_neighbors = 0;  // of a voxel
  std::uint32_t turn = 0;
  std::uint32_t cluster_count = 0;
  std::vector<Cluster> clusters;     // more than there are, so that their candidates keep their memory
  std::vector<Claim> claims;         // of a turn
  std::vector<Assignment> layer;     // of voxels that the rounds did not reach
  std::vector<std::uint32_t> fresh;  // candidates that a turn adds
  std::vector<std::uint32_t> rest;   // voxels that the rounds did not reach
  std::vector<std::uint32_t> number;

  void clear(std::size_t size) {
    voxels.resize(size);
    most_neighbors = 0;
    turn = cluster_count = 0;
  }
  std::uint32_t new_cluster() {
    if (cluster_count == clusters.size()) clusters.emplace_back();
    clusters[cluster_count].clear();
    return cluster_count++;
  }
};

}  // namespace segserve::growth
