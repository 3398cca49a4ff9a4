#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "segserve/math/vec3.hpp"

// What growth keeps of voxels and clusters: of this folder alone.

namespace segserve::growth {

inline constexpr std::uint32_t kNobody = std::numeric_limits<std::uint32_t>::max();
inline constexpr float kUnreached = std::numeric_limits<float>::infinity();

/// What distances are measured on, scaled by the weights: position, colour, normal. In the order in which four of them
/// are read at once.
struct Feature {
  float px, py, pz, nx, cr, cg, cb, ny, nz;

  static Feature of(const Vec3& position, const Vec3& color, const Vec3& normal) {
    const auto f = [](double v) { return static_cast<float>(v); };
    return {f(position.x), f(position.y), f(position.z), f(normal.x), f(color.x),
            f(color.y),    f(color.z),    f(normal.y),   f(normal.z)};
  }
};

/// What a turn measures of a voxel, side by side: one cache line, mostly. Its owner and its last turn are arrays of
/// their own, which nearly fit the first-level cache: turns look at those of many more voxels.
struct Voxel {
  Feature feature;
  float distance;  // to the owner's centre when it took the voxel
};

struct FeatureSum {
  Vec3 position, color, normal;

  void add(const Feature& f, double sign) {
    position += sign * Vec3{f.px, f.py, f.pz};
    color += sign * Vec3{f.cr, f.cg, f.cb};
    normal += sign * Vec3{f.nx, f.ny, f.nz};
  }
  Feature mean(std::size_t count) const {
    const double scale = 1 / static_cast<double>(count);
    return Feature::of(scale * position, scale * color, unit(normal));
  }
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

/// A voxel that is about to change hands.
struct Claim {
  std::uint32_t voxel, cluster;
  float distance;
};

/// Kept between calls for its memory.
struct State {
  std::vector<Voxel> voxels;         // V
  std::vector<std::uint32_t> owner;  // V: a cluster, or kNobody
  std::vector<std::uint32_t> seen;   // V: the last turn that had the voxel among its candidates
  std::uint32_t turn = 0;
  std::uint32_t cluster_count = 0;
  std::vector<Cluster> clusters;     // more than there are, so that their candidates keep their memory
  std::vector<Claim> claims;         // of a turn, or of a layer
  std::vector<std::uint32_t> fresh;  // candidates that a turn adds
  std::vector<std::uint32_t> rest;   // voxels that the rounds did not reach
  std::vector<std::uint32_t> number;

  void clear(std::size_t size) {
    voxels.resize(size);
    owner.assign(size, kNobody);
    seen.assign(size, 0);
    turn = cluster_count = 0;
  }
  std::uint32_t new_cluster() {
    if (cluster_count == clusters.size()) clusters.emplace_back();
    clusters[cluster_count].clear();
    return cluster_count++;
  }
};

}  // namespace segserve::growth
