// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "core/base/frame_context.hpp"
#include "core/math/symmetric_matrix3.hpp"
#include "core/math/vec3.hpp"
#include "core/region_graph/region_edge.hpp"
#include "core/supervoxels/supervoxel_growth.hpp"
#include "core/voxels/voxel_adjacency.hpp"
#include "core/voxels/voxel_grid.hpp"

namespace segserve {

/// Sums over the voxels of a region (geometry) and over its input points (color), so that two regions merge in O(1).
struct Region {
  double voxels = 0;
  std::uint32_t points = 0;
  Vec3 centroid;       ///< mean of the centroids of the voxels, meters
  Symmetric3 scatter;  ///< of the centroids of the voxels about their mean, m^2
  Vec3 normal_sum;     ///< of the unit normals of the voxels
  Vec3 color_sum;      ///< of (R, G, B), 0..255, over the points

  /// Merges a disjoint region into this one; the scatter by Chan, Golub and LeVeque (1979).
  void merge(const Region& other);
};

/// Two neighboring voxels of different supervoxels; v < u.
struct Contact {
  std::uint32_t v = 0, u = 0;
};

/// The region adjacency graph G^m of the paper: the supervoxels, and which of them are adjacent.
struct RegionGraph {
  std::vector<Region> regions;                 ///< m
  std::vector<RegionEdge> edges;               ///< E: ascending by (a, b)
  std::vector<Contact> contacts;               ///< C: ascending by (v, u)
  std::vector<std::uint32_t> edge_of_contact;  ///< C: below E
};

/// Builds the region adjacency graph. Supervoxels are adjacent if a voxel of one is a neighbor of a voxel of the other.
class RegionGraphConstruction {
 public:
  /// `normals` has a unit vector, or 0, for each voxel. O(V + N + E log E) for V voxels with N neighbors.
  /// CANCELLED, DEADLINE_EXCEEDED.
  absl::Status run(const FrameContext& frame, const VoxelGrid& grid, const VoxelAdjacency& adjacency,
                   const std::vector<Vec3>& normals, const Supervoxels& supervoxels, RegionGraph& graph);

  /// Buffers of the counting sort of contacts by the smaller of their supervoxels.
  struct Scratch {
    struct SortedContact {
      std::uint32_t contact, larger_supervoxel;
    };
    std::vector<std::uint32_t> begin, next;  ///< of each supervoxel's contacts in `sorted`
    std::vector<SortedContact> sorted;       ///< C
    std::vector<std::uint32_t> edge_to;      ///< m: 1 + the last edge to each supervoxel, or 0
  };

 private:
  Scratch scratch_;
};

}  // namespace segserve
