#include "segserve/pipeline/segment.hpp"

#include <chrono>
#include <utility>

#include "segserve/graph/region_graph.hpp"
#include "segserve/merge/merge.hpp"
#include "segserve/metric/paper_metric.hpp"
#include "segserve/pipeline/parallel.hpp"
#include "segserve/supervoxel/growth.hpp"
#include "segserve/supervoxel/seeds.hpp"
#include "segserve/voxel/adjacency.hpp"
#include "segserve/voxel/normals.hpp"
#include "segserve/voxel/voxel_grid.hpp"

namespace segserve {
namespace {

/// Milliseconds since the last lap.
class Stopwatch {
 public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    return std::chrono::duration<double, std::milli>(now - std::exchange(last_, now)).count();
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

absl::StatusOr<Cut> cut(const MergeTree& tree, const Options& options, double threshold) {
  return options.regions ? cut_to_regions(tree, *options.regions) : cut_at_threshold(tree, threshold);
}

/// A value per supervoxel becomes one per point; 0 stays with points that are not finite.
template <typename ValueOfSupervoxel>
std::vector<std::uint32_t> spread(const VoxelGrid& grid, const Supervoxels& supervoxels, unsigned threads,
                                  ValueOfSupervoxel&& value) {
  std::vector<std::uint32_t> value_of_slot(grid.voxel_of_slot.size(), 0);
  for (std::size_t slot = 1; slot < value_of_slot.size(); ++slot) {
    value_of_slot[slot] = value(supervoxels.of_voxel[grid.voxel_of_slot[slot]]);
  }
  std::vector<std::uint32_t> result(grid.slot_of_point.size());
  parallel_ranges(result.size(), threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) result[i] = value_of_slot[grid.slot_of_point[i]];
  });
  return result;
}

}  // namespace

struct Segmenter::Workspace {
  VoxelizeScratch voxelize;
  VoxelGrid grid;
  VoxelAdjacency adjacency;
  std::vector<Vec3> normals;
  Seeds seeds;
};

Segmenter::Segmenter() : workspace_(std::make_unique<Workspace>()) {}
Segmenter::~Segmenter() = default;
Segmenter::Segmenter(Segmenter&&) noexcept = default;
Segmenter& Segmenter::operator=(Segmenter&&) noexcept = default;

absl::StatusOr<Segmentation> Segmenter::segment(const CloudView& cloud, const Options& options,
                                                const StopToken& stop) {
  if (absl::Status status = check(options); !status.ok()) return status;
  if (absl::Status status = check_shape(cloud); !status.ok()) return status;
  auto& [voxelize_scratch, grid, adjacency, normals, seeds] = *workspace_;
  Segmentation result;
  StageTimings& timings = result.timings;
  Stopwatch total, watch;

  // The cloud becomes voxels, each with the mean of its points ..
  if (absl::Status status = voxelize(cloud, options.voxel_resolution, options.threads, stop, voxelize_scratch, grid);
      !status.ok()) {
    return status;
  }
  timings.voxels = watch.lap();

  // .. and a normal, from the plane through its neighbourhood.
  find_adjacency(grid, adjacency);
  if (absl::Status status = compute_normals(grid, adjacency, cloud.view, options.threads, stop, normals);
      !status.ok()) {
    return status;
  }
  timings.normals = watch.lap();

  // Over-segmentation: the supervoxels R^m (VCCS).
  select_seeds(grid, cloud.view, options.voxel_resolution, options.seed_resolution, seeds);
  const absl::StatusOr<Supervoxels> supervoxels = grow_supervoxels(grid, adjacency, normals, seeds, options, stop);
  if (!supervoxels.ok()) return supervoxels.status();
  timings.supervoxels = watch.lap();

  // The weighted graph G^m = {R^m, W^m}, weights by the metric delta (eq. 3).
  const RegionGraph graph = build_region_graph(grid, adjacency, normals, *supervoxels);
  PaperMetric metric(graph, cloud.view, options);
  result.lambda = metric.lambda();
  timings.graph = watch.lap();

  // The two most similar regions become one, again and again: the dendrogram D.
  absl::StatusOr<MergeTree> tree = merge_regions<PaperMetric>(
      graph.edges, std::vector<PaperMetric::Evidence>(graph.edges.size()), metric, stop);
  if (!tree.ok()) return tree.status();
  result.tree = *std::move(tree);
  timings.merging = watch.lap();

  // One level of it labels every input point.
  result.threshold = options.threshold.value_or(default_threshold(options.method));
  const absl::StatusOr<Cut> level = cut(result.tree, options, result.threshold);
  if (!level.ok()) return level.status();
  result.segments = level->segments;
  result.labels = spread(grid, *supervoxels, options.threads, [&](std::uint32_t s) { return level->segment_of_leaf[s]; });
  result.supervoxels = spread(grid, *supervoxels, options.threads, [](std::uint32_t s) { return s + 1; });
  timings.labels = watch.lap();

  result.finite_points = grid.finite_points;
  result.voxels = grid.size();
  timings.total = total.lap();
  return result;
}

absl::StatusOr<Segmentation> segment(const CloudView& cloud, const Options& options, const StopToken& stop) {
  return Segmenter().segment(cloud, options, stop);
}

}  // namespace segserve
