#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "segserve/supervoxel/state.hpp"

namespace segserve::growth {

/// The distance of VCCS between features that are scaled by their weights.
class Distance {
 public:
  explicit Distance(float normal_weight) : normal_weight_(normal_weight) {}

  float operator()(const Feature& a, const Feature& b) const {
    const float px = a.px - b.px, py = a.py - b.py, pz = a.pz - b.pz;
    const float cr = a.cr - b.cr, cg = a.cg - b.cg, cb = a.cb - b.cb;
    const float cosine = a.nx * b.nx + a.ny * b.ny + a.nz * b.nz;
    return std::sqrt(px * px + py * py + pz * pz) + std::sqrt(cr * cr + cg * cg + cb * cb) +
           normal_weight_ * (1.0F - std::fabs(cosine));
  }

  /// Of the voxels `of`[0 .. count) from the centre, four at a time: the same bits, and a tenth off the
  /// whole of growth.
  void measure(const Feature& centre, const Voxel* voxels, const std::uint32_t* of, std::size_t count,
               float* distances) const {
    std::size_t i = 0;
    for (; i + 4 <= count; i += 4) {
      const Four d = four(centre, voxels, of + i);
      std::memcpy(distances + i, &d, sizeof(d));
    }
    for (; i < count; ++i) distances[i] = (*this)(centre, voxels[of[i]].feature);
  }

 private:
  using Four = float __attribute__((vector_size(16)));  // SSE2, NEON or plain code

  /// Rows a, b, c, d become columns.
  static void transpose(Four& a, Four& b, Four& c, Four& d) {
    const Four ab_low = __builtin_shufflevector(a, b, 0, 4, 1, 5), ab_high = __builtin_shufflevector(a, b, 2, 6, 3, 7);
    const Four cd_low = __builtin_shufflevector(c, d, 0, 4, 1, 5), cd_high = __builtin_shufflevector(c, d, 2, 6, 3, 7);
    a = __builtin_shufflevector(ab_low, cd_low, 0, 1, 4, 5);
    b = __builtin_shufflevector(ab_low, cd_low, 2, 3, 6, 7);
    c = __builtin_shufflevector(ab_high, cd_high, 0, 1, 4, 5);
    d = __builtin_shufflevector(ab_high, cd_high, 2, 3, 6, 7);
  }
  static Four load(const float* from) {
    Four v;
    std::memcpy(&v, from, sizeof(v));
    return v;
  }
  static Four root(const Four& v) {
#ifdef __SSE__
    return __builtin_ia32_sqrtps(v);  // GCC 12 makes it four instructions of one root each
#else
    return Four{std::sqrt(v[0]), std::sqrt(v[1]), std::sqrt(v[2]), std::sqrt(v[3])};
#endif
  }
  static Four length(const Four& x, const Four& y, const Four& z) { return root(x * x + y * y + z * z); }

  Four four(const Feature& centre, const Voxel* voxels, const std::uint32_t* of) const {
    const Feature &a = voxels[of[0]].feature, &b = voxels[of[1]].feature, &c = voxels[of[2]].feature,
                  &d = voxels[of[3]].feature;
    Four px = load(&a.px), py = load(&b.px), pz = load(&c.px), nx = load(&d.px);
    transpose(px, py, pz, nx);
    Four cr = load(&a.cr), cg = load(&b.cr), cb = load(&c.cr), ny = load(&d.cr);
    transpose(cr, cg, cb, ny);
    const Four nz{a.nz, b.nz, c.nz, d.nz};
    const Four cosine = centre.nx * nx + centre.ny * ny + centre.nz * nz;
    const Four absolute = cosine < 0 ? -cosine : cosine;
    return length(centre.px - px, centre.py - py, centre.pz - pz) +
           length(centre.cr - cr, centre.cg - cg, centre.cb - cb) + normal_weight_ * (1.0F - absolute);
  }

  float normal_weight_;
};

}  // namespace segserve::growth
