#pragma once

#include <cstddef>
#include <cstdint>

#include "core/math/vec3.hpp"

namespace segserve {

/// x, y, z of a voxel, aligned so that they are one load; w is for whoever makes it.
struct alignas(32) Quad {
  double x, y, z, w;
};

inline Quad quad(const Vec3& v, double w) { return {v.x, v.y, v.z, w}; }

/// Number, sum and second moments of the centroids of a voxel and its neighbours, about its own centroid.
struct alignas(32) RingMoments {
  double x, y, z, count;
  double xx, xy, xz, yy;
  double yz, zz, unused[2];
};

/// Neighbours as in VoxelAdjacency.
struct NeighborRows {
  const std::uint32_t* offset;
  const std::uint32_t* neighbor;
};

/// Voxels by columns (VoxelWindows). Arrays have kWindowPadding more entries, of any finite value.
struct WindowColumns {
  const double *x, *y, *z;           ///< centroids
  const float *nx, *ny, *nz;         ///< normals, if they are known
  const float* inverse_square_edge;  ///< of the voxels
  const std::int32_t* cell_x;        ///< x of the voxels' cells
};
inline constexpr std::size_t kWindowPadding = 8;

/// Consecutive voxels of one row of cells; at most kWindowPadding.
struct RowSpan {
  std::uint32_t first, count;
};
inline constexpr std::size_t kMostRowSpans = 25;

struct SpanCount {
  std::uint32_t spans, voxels;
};

/// The voxels of a row of cells that are not yet done with.
struct CellRow {
  std::uint32_t next, end;
};

/// Voxels side by side, and all voxels at most two cells away from any of them, row by row.
struct WindowGroup {
  static constexpr std::size_t kMost = 4;
  RowSpan voxels;  ///< of one row, in 4 neighbouring cells of it
  std::uint32_t first_span, span_count;
  std::uint32_t candidates;  ///< voxels of the spans
};

/// Groups from `begin` to `end`, with their spans.
struct WindowGroups {
  const WindowGroup *begin, *end;
  const RowSpan* spans;
};

/// How refit_windows weighs a neighbour (EdgeAwareOptions).
struct RefitScales {
  float angle;    ///< of 1 - cosine in the exponent
  float offset;   ///< of the squared offset, in voxels, in the exponent
  float support;  ///< sum of weights up to which the first normal stays
};

/// The inner loops of the normals, compiled once for each kind of CPU. All give the same bytes.
struct NormalKernels {
  /// Moments of the first rings of the voxels [begin, end). `centroid`: w = 0.
  void (*ring_moments)(std::size_t begin, std::size_t end, const NeighborRows& rows, const Quad* centroid,
                       RingMoments* rings);
  /// Normals, of either sign, of the planes through both rings of the voxels [begin, end).
  void (*fit_planes)(std::size_t begin, std::size_t end, const NeighborRows& rows, const Quad* centroid,
                     const RingMoments* rings, Vec3* normals);
  /// Which voxels of `count` rows are in the cells with x from left to right, at most kWindowPadding. Room for
  /// kMostRowSpans. To be called with ascending limits: `next` moves with them.
  SpanCount (*find_spans)(const std::int32_t* cell_x, std::int32_t left, std::int32_t right, CellRow* rows,
                          std::size_t count, RowSpan* spans);
  /// Normals of either sign of the planes through the windows of the groups' voxels (window_normals).
  void (*fit_windows)(const WindowColumns& columns, const WindowGroups& groups, Vec3* normals);
  /// Gives the groups' voxels their new normals (refine_normals); columns and `normals` hold the first ones.
  void (*refit_windows)(const WindowColumns& columns, const RefitScales& scales, const WindowGroups& groups,
                        Vec3* normals);
};

/// Those for `cpu_in_use`.
const NormalKernels& normal_kernels();

}  // namespace segserve
