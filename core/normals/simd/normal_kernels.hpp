// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/math/vec3.hpp"

namespace segserve {

/// A vector with a fourth number, aligned so that all four are one load.
struct alignas(32) PaddedVec3 {
  double x, y, z, w;
};

/// Sums over the centroids of a voxel and its neighbors, relative to its own centroid.
struct alignas(32) RingMoments {
  double first[4];   ///< of x, y and z, and how many centroids there are
  double second[6];  ///< of xx, xy, xz, yy, yz and zz
};

/// The arrays of VoxelAdjacency.
struct NeighborRows {
  const std::uint32_t* offset;
  const std::uint32_t* neighbor;
};

/// The columns of Neighborhoods. They have kColumnPadding more entries, of any finite value.
struct VoxelColumns {
  const double *x, *y, *z;           ///< centroids
  const float *nx, *ny, *nz;         ///< normals; only refit_neighborhoods reads them
  const float* inverse_square_edge;  ///< 1 / edge^2
  const std::int32_t* cell_x;        ///< x of their cells
};
inline constexpr std::size_t kColumnPadding = 8;

/// Consecutive voxels of one row of cells; at most kColumnPadding.
struct RowSpan {
  std::uint32_t first, count;
};
inline constexpr std::size_t kMostRowSpans = 25;

struct SpanCount {
  std::uint32_t spans, voxels;
};

/// The voxels of a row of cells that are still to come.
struct CellRow {
  std::uint32_t next, end;
};

/// Voxels side by side, with all voxels that are at most two cells away from any of them, row by row.
struct VoxelGroup {
  static constexpr std::size_t kMost = 4;
  RowSpan voxels;                        ///< in kMost neighboring cells of one row
  std::uint32_t first_span, span_count;  ///< spans of the nearby voxels, among VoxelGroups::spans
  std::uint32_t candidates;              ///< how many voxels the spans have
};

/// The groups from `begin` to `end`, and the spans to which they refer.
struct VoxelGroups {
  const VoxelGroup *begin, *end;
  const RowSpan* spans;
};

/// The weights of refit_neighborhoods (RefinementOptions).
struct RefitScales {
  float angle;    ///< factor of 1 - cosine in the exponent
  float offset;   ///< factor of the squared offset, in voxels, in the exponent
  float support;  ///< sum of weights up to which the first normal stays
};

/// The inner loops of the normals, compiled once for each SimdTarget. All versions give the same bytes.
struct NormalKernels {
  /// Computes the moments of the first rings of the voxels [begin, end). The fourth numbers of the centroids are 0.
  void (*ring_moments)(std::size_t begin, std::size_t end, const NeighborRows& rows, const PaddedVec3* centroid,
                       RingMoments* rings);
  /// Fits planes to both rings of the voxels [begin, end). The normals may have either sign.
  void (*fit_planes)(std::size_t begin, std::size_t end, const NeighborRows& rows, const PaddedVec3* centroid,
                     const RingMoments* rings, Vec3* normals);
  /// Finds the voxels of `count` rows in the cells with x from left to right, at most kColumnPadding cells. There must
  /// be room for kMostRowSpans spans. Calls must have ascending limits, because `next` of the rows moves with them.
  SpanCount (*find_spans)(const std::int32_t* cell_x, std::int32_t left, std::int32_t right, CellRow* rows,
                          std::size_t count, RowSpan* spans);
  /// Fits planes to the neighborhoods of the voxels of the groups. The normals may have either sign.
  void (*fit_neighborhoods)(const VoxelColumns& columns, const VoxelGroups& groups, Vec3* normals);
  /// Replaces the normals of the voxels of the groups by edge-aware ones. Columns and `normals` hold the first normals.
  void (*refit_neighborhoods)(const VoxelColumns& columns, const RefitScales& scales, const VoxelGroups& groups,
                              Vec3* normals);
};

/// The kernels for `simd_target`.
const NormalKernels& normal_kernels();

}  // namespace segserve
