#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/math/symmetric_matrix3.hpp"
#include "core/math/vec3.hpp"
#include "core/region_graph/region_edge.hpp"
#include "core/supervoxels/growth.hpp"
#include "core/voxels/voxel_adjacency.hpp"
#include "core/voxels/voxel_grid.hpp"

namespace segserve {

/// What is kept of a region, so that merging two takes O(1): sums over its voxels (geometry) and its
/// input points (colour).
struct Region {
  double voxels = 0;
  std::uint32_t points = 0;
  double area = 0;     ///< sum of the voxels' faces, m^2
  Vec3 centroid;       ///< mean of the voxels' centroids, metres
  Symmetric3 scatter;  ///< of the voxels' centroids about their mean, m^2
  Vec3 normal_sum;     ///< of the voxels' unit normals
  Vec3 color_sum;      ///< of (R, G, B), 0..255, over the points

  /// Unites two disjoint regions; the scatter by Chan, Golub and LeVeque (1979).
  void merge(const Region& other);
};

/// Neighbouring voxels of two supervoxels; v < u.
struct Contact {
  std::uint32_t v = 0, u = 0;
};

/// G^m of the paper: the supervoxels and which of them are adjacent, edges ascending by (a, b).
struct RegionGraph {
  std::vector<Region> regions;  ///< m
  std::vector<RegionEdge> edges;
  std::span<const Contact> contacts;  ///< all that edges stand for, ascending by (v, u); they are in the GraphScratch
};

/// Buffers of `build_region_graph` that are worth keeping between calls.
struct GraphScratch {
  std::vector<Contact> contacts;
  std::vector<std::uint64_t> met;
  std::vector<std::uint32_t> begin, next, larger, last_met;
};

/// Supervoxels are adjacent if a voxel of one is a neighbour of a voxel of the other.
/// If stopped, the graph is useless.
void build_region_graph(const VoxelGrid& grid, const VoxelAdjacency& adjacency, const std::vector<Vec3>& normals,
                        const Supervoxels& supervoxels, const View& view, double voxel_resolution,
                        const StopToken& stop, GraphScratch& scratch, RegionGraph& graph);

}  // namespace segserve
