#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "segserve/math/vec3.hpp"

// What growth keeps of voxels and clusters: of growth.cpp alone.

namespace segserve::growth {

inline constexpr std::uint32_t kNobody = std::numeric_limits<std::uint32_t>::max();
inline constexpr float kUnreached = std::numeric_limits<float>::infinity();

/// What distances are measured on, scaled by the weights: position, colour, normal.
struct Feature {
  float px, py, pz, cr, cg, cb, nx, ny, nz;
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
    const Vec3 p = scale * position;
    const Vec3 c = scale * color;
    const Vec3 n = unit(normal);
    const auto f = [](double v) { return static_cast<float>(v); };
    return {f(p.x), f(p.y), f(p.z), f(c.x), f(c.y), f(c.z), f(n.x), f(n.y), f(n.z)};
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

}  // namespace segserve::growth
