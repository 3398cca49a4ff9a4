#include "core/normals/two_ring_normals.hpp"

#include "core/base/stop_check.hpp"
#include "core/normals/normal_orientation.hpp"
#include "core/voxels/voxel_blocks.hpp"

namespace segserve {

Vec3 sensor_of(const View& view) {
  return view.sensor ? Vec3{(*view.sensor)[0], (*view.sensor)[1], (*view.sensor)[2]} : Vec3{};
}

// With the adjacency A that includes the voxel itself, and M the moments of single centroids, the two rings have the
// moments M + A M + A (A M): two sparse passes instead of a visit to 81 voxels. Moments are about the voxel's own
// centroid, which keeps them exact far from the origin.
absl::Status compute_normals(const VoxelGrid& grid, const VoxelAdjacency& adjacency, const View& view, unsigned threads,
                             const StopToken& stop, NormalsScratch& scratch, std::vector<Vec3>& normals) {
  const NormalKernels& kernels = normal_kernels();
  const NeighborRows rows{adjacency.offset.data(), adjacency.neighbor.data()};
  scratch.centroid.resize(grid.size());
  scratch.rings.resize(grid.size());
  normals.resize(grid.size());
  const bool complete =
      StopCheck(stop).for_each(0, grid.size(), [&](std::size_t v) { scratch.centroid[v] = quad(grid.centroid[v], 0); });
  if (!complete) return stop.check();
  for_voxel_blocks(adjacency, threads, stop, [&](std::size_t first, std::size_t last) {
    kernels.ring_moments(first, last, rows, scratch.centroid.data(), scratch.rings.data());
  });
  if (absl::Status status = stop.check(); !status.ok()) return status;
  const Vec3 sensor = sensor_of(view);
  for_voxel_blocks(adjacency, threads, stop, [&](std::size_t first, std::size_t last) {
    kernels.fit_planes(first, last, rows, scratch.centroid.data(), scratch.rings.data(), normals.data());
    if (!view.has_sensor()) return;
    for (std::size_t v = first; v < last; ++v) normals[v] = turn_to_sensor(normals[v], grid.centroid[v], sensor);
  });
  if (absl::Status status = stop.check(); !status.ok()) return status;
  return view.has_sensor() ? absl::OkStatus() : orient_consistently(adjacency, stop, normals);
}

}  // namespace segserve
