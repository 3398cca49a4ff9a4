#pragma once

#include <vector>

#include "core/region_graph/region_graph.hpp"

namespace segserve {

/// What the border between two supervoxels is like.
struct Border {
  double voxel_pairs = 0;  ///< pairs of neighbouring voxels across it, at least 1
  double concavity = 0;    ///< mean over the pairs of the angle by which they are concave beyond the dead zone, degrees
};

/// The border of every edge of the graph, in its order. A pair of voxels with normals n and centroids x is concave
/// if (na - nb) . (xa - xb) < 0, by the angle of its normals; `dead_zone` (degrees) is taken off that. Where a
/// normal is not defined the angle counts as 0. If stopped, the borders are useless.
void measure_borders(const RegionGraph& graph, const VoxelGrid& grid, const std::vector<Vec3>& normals,
                     const Supervoxels& supervoxels, double dead_zone, const StopToken& stop,
                     std::vector<Border>& borders);

}  // namespace segserve
