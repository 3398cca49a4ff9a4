#include <algorithm>
#include <chrono>
#include <numeric>
#include <utility>

#include "core/base/parallel.hpp"
#include "core/base/stop_check.hpp"
#include "core/merging/merger.hpp"
#include "core/normals/edge_aware_normals.hpp"
#include "core/normals/neighborhoods.hpp"
#include "core/normals/normal_orientation.hpp"
#include "core/normals/two_ring_normals.hpp"
#include "core/region_graph/borders.hpp"
#include "core/region_graph/region_graph.hpp"
#include "core/supervoxels/growth.hpp"
#include "core/supervoxels/seeds.hpp"
#include "core/support_plane/support_plane_finder.hpp"
#include "core/voxels/component_bridging.hpp"
#include "core/voxels/voxel_adjacency.hpp"
#include "core/voxels/voxel_grid.hpp"
#include "core/weights/border_metric.hpp"
#include "core/weights/paper_metric.hpp"
#include "segserve/segment.hpp"

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

/// From which threshold on no region that is too small is left. The tree does not depend on the threshold of the
/// request, so that it serves all of them, unless the caller has a say in what is too small.
double settled_threshold(const Options& options) {
  const double standard = default_threshold(options.method);
  return options.min_segment_points > 0 ? options.threshold.value_or(standard) : standard;
}

/// The border method's neighbours and normals: surfaces hang together where they are sparser than the voxels, and
/// normals have the right side where the sensor cannot have seen them.
absl::Status border_normals(const VoxelGrid& grid, const View& view, const SupervoxelOptions& settings,
                            unsigned threads, const StopToken& stop, VoxelWindows& windows, VoxelAdjacency& adjacency,
                            std::vector<Vec3>& normals) {
  const double voxel = settings.voxel_resolution;
  absl::Status status = bridge_islands(grid, view, voxel, {}, stop, adjacency);
  if (status.ok()) status = find_windows(grid, view, voxel, threads, stop, windows);
  if (status.ok()) status = window_normals(grid, adjacency, view, stop, windows, normals);
  if (status.ok() && view.sensor) status = orient_hidden(grid, adjacency, view, voxel, stop, normals);
  if (status.ok()) status = refine_normals({}, stop, windows, normals);
  return status;
}

/// The dendrogram by the paper's metric delta (eq. 3). `lambda`: what Adaptive Lambda found.
absl::StatusOr<MergeTree> merge_by_paper(const RegionGraph& graph, const View& view, const Options& options,
                                         const StopToken& stop, Merger<PaperMetric>::Scratch& scratch, double& lambda) {
  PaperMetric metric(graph, view, options, stop);
  if (absl::Status status = stop.check(); !status.ok()) return status;
  lambda = metric.lambda();
  const std::vector<PaperMetric::Evidence> none(graph.edges.size());
  return merge_regions<PaperMetric>(graph.edges, none, settled_threshold(options), metric, stop, scratch);
}

/// The dendrogram by what the borders between supervoxels look like.
absl::StatusOr<MergeTree> merge_by_border(const RegionGraph& graph, const VoxelGrid& grid,
                                          const std::vector<Vec3>& normals, const Supervoxels& supervoxels,
                                          const Options& options, const StopToken& stop, std::vector<Border>& borders,
                                          Merger<BorderMetric>::Scratch& scratch) {
  const BorderOptions constants;
  const SupervoxelOptions settings = supervoxel_options(options);
  measure_borders(graph, grid, normals, supervoxels, constants.dead_zone, stop, borders);
  if (absl::Status status = stop.check(); !status.ok()) return status;
  const std::vector<BorderMetric::Evidence> evidence =
      border_evidence(graph, borders, settings.voxel_resolution, settings.seed_resolution, constants, stop);
  if (absl::Status status = stop.check(); !status.ok()) return status;
  BorderMetric metric(graph, options.min_segment_points, constants);
  return merge_regions<BorderMetric>(graph.edges, evidence, settled_threshold(options), metric, stop, scratch);
}

absl::StatusOr<Cut> cut(const MergeTree& tree, const Options& options, const StopToken& stop) {
  return options.regions ? cut_to_regions(tree, *options.regions, stop)
                         : cut_at_threshold(tree, *options.threshold, stop);
}

/// Takes the support plane's voxels, which it finds by their normals, out of the grid and its adjacency.
absl::Status remove_support_plane(double distance, const View& view, unsigned threads, const StopToken& stop,
                                  VoxelGrid& grid, VoxelAdjacency& adjacency, std::vector<Vec3>& normals,
                                  SupportPlane& plane) {
  if (absl::Status status = compute_normals(grid, adjacency, view, threads, stop, normals); !status.ok()) return status;
  const PlaneVoxels found = find_support_plane(grid, adjacency, normals, view, distance, stop);
  if (absl::Status status = stop.check(); !status.ok()) return status;
  plane = found.plane;
  remove_voxels(found.member, stop, grid);
  find_adjacency(grid, adjacency, stop);
  return stop.check();
}

/// A stage's buffers are kept for the next cloud, which saves page faults; but of a cloud with this many voxels, where
/// all stages' together take 500 bytes a voxel, they make room for the next stage's. Not those of the first, whose
/// table would have to grow again: a tenth of the time.
constexpr std::size_t kManyVoxels = 250'000;

template <typename... Scratch>
void make_room(const VoxelGrid& grid, Scratch&... scratch) {
  if (grid.size() >= kManyVoxels) ((scratch = Scratch()), ...);
}

/// What a point gets: its segment and its supervoxel, both 0 if it is not segmented.
struct PointLabels {
  std::uint32_t segment = 0, supervoxel = 0;
};

/// What the supervoxels have becomes the points'. Both at once: one table, one gather, one pass over the points, whose
/// slots the grid hands over: their memory becomes the result's, four bytes a point less.
void spread(VoxelGrid& grid, const Supervoxels& supervoxels, const Cut& cut, unsigned threads, const StopToken& stop,
            std::vector<PointLabels>& of_slot, Segmentation& result) {
  of_slot.assign(grid.voxel_of_slot.size(), PointLabels{});
  StopCheck(stop).for_each(1, of_slot.size(), [&](std::size_t slot) {
    const std::uint32_t voxel = grid.voxel_of_slot[slot];
    if (voxel == kNoVoxel) return;
    const std::uint32_t s = supervoxels.of_voxel[voxel];
    of_slot[slot] = {cut.segment_of_leaf[s], s + 1};
  });
  result.supervoxels = std::move(grid.slot_of_point);
  const std::size_t points = result.supervoxels.size();
  result.labels.resize(points);
  parallel_ranges(points, threads, [&](std::size_t begin, std::size_t end) {
    StopCheck(stop, threads).for_each_block(begin, end, [&](std::size_t first, std::size_t last) {
      const PointLabels* labels = of_slot.data();
      std::uint32_t* segment = result.labels.data();
      std::uint32_t* supervoxel = result.supervoxels.data();
      for (std::size_t i = first; i < last; ++i) {
        const PointLabels of_point = labels[supervoxel[i]];
        segment[i] = of_point.segment;
        supervoxel[i] = of_point.supervoxel;
      }
    });
  });
}

}  // namespace

struct Segmenter::Workspace {
  VoxelizeScratch voxelize;
  VoxelGrid grid;
  VoxelAdjacency adjacency;
  NormalsScratch normals_scratch;
  VoxelWindows windows;
  std::vector<Vec3> normals;
  SeedScratch seeding;
  Seeds seeds;
  GrowthScratch growth;
  Supervoxels supervoxels;
  GraphScratch graph_scratch;
  RegionGraph graph;
  std::vector<Border> borders;
  Merger<BorderMetric>::Scratch border_merging;
  Merger<PaperMetric>::Scratch paper_merging;
  std::vector<PointLabels> labels;
};

Segmenter::Segmenter() : workspace_(std::make_unique<Workspace>()) {}
Segmenter::~Segmenter() = default;
Segmenter::Segmenter(Segmenter&&) noexcept = default;
Segmenter& Segmenter::operator=(Segmenter&&) noexcept = default;

absl::StatusOr<Segmentation> Segmenter::segment(const CloudView& cloud, const Options& requested,
                                                const StopToken& stop) {
  if (absl::Status status = check(requested, cloud.view); !status.ok()) return status;
  if (absl::Status status = check_shape(cloud); !status.ok()) return status;
  const Options options = resolved(requested);
  const SupervoxelOptions settings = supervoxel_options(options);
  auto& [scratch, grid, adjacency, normals_scratch, windows, normals, seeding, seeds, growth, supervoxels,
         graph_scratch, graph, borders, border_merging, paper_merging, labels] = *workspace_;
  Segmentation result;
  StageTimings& timings = result.timings;
  Stopwatch total, watch;
  absl::Status status;

  // The cloud, or the part of it that is asked for, becomes voxels, each with the mean of its points ..
  status =
      voxelize(cloud, settings.voxel_resolution, options.threads, stop, scratch, grid, Selection(options, cloud.view));
  if (!status.ok()) return status;
  if (grid.size() >= kManyVoxels) {  // of scattered points, its table is most of the memory of all stages
    for (VoxelPart& part : scratch.parts) part.table.free_if_scattered();
  }
  timings.voxels = watch.lap();

  // .. and a normal, from the plane through its neighbourhood; ours does not reach across edges. What supports the
  // objects goes before, if it shall.
  find_adjacency(grid, adjacency, stop);
  if (status = stop.check(); !status.ok()) return status;
  if (options.support_plane_distance) {
    status = remove_support_plane(*options.support_plane_distance, cloud.view, options.threads, stop, grid, adjacency,
                                  normals, result.support_plane.emplace());
    if (!status.ok()) return status;
  }
  status = options.method == Method::kBorder
               ? border_normals(grid, cloud.view, settings, options.threads, stop, windows, adjacency, normals)
               : compute_normals(grid, adjacency, cloud.view, options.threads, stop, normals_scratch, normals);
  if (!status.ok()) return status;
  make_room(grid, normals_scratch, windows);
  timings.normals = watch.lap();

  // Over-segmentation: the supervoxels R^m (VCCS).
  select_seeds(grid, cloud.view, settings.voxel_resolution, settings.seed_resolution, seeding, seeds, stop);
  if (status = stop.check(); !status.ok()) return status;
  status = grow_supervoxels(grid, adjacency, normals, seeds, settings, stop, growth, supervoxels);
  if (!status.ok()) return status;
  make_room(grid, seeding, seeds, growth);
  timings.supervoxels = watch.lap();

  // The region adjacency graph G^m.
  build_region_graph(grid, adjacency, normals, supervoxels, cloud.view, settings.voxel_resolution, stop, graph_scratch,
                     graph);
  result.supervoxel_normals.resize(graph.regions.size());
  StopCheck(stop).for_each(0, graph.regions.size(),
                           [&](std::size_t s) { result.supervoxel_normals[s] = graph.regions[s].normal_sum; });
  if (status = stop.check(); !status.ok()) return status;
  timings.graph = watch.lap();

  // Its weights W^m; then the two most similar regions become one, again and again: the dendrogram D.
  absl::StatusOr<MergeTree> tree =
      options.method == Method::kBorder
          ? merge_by_border(graph, grid, normals, supervoxels, options, stop, borders, border_merging)
          : merge_by_paper(graph, cloud.view, options, stop, paper_merging, result.lambda);
  if (!tree.ok()) return tree.status();
  result.tree = *std::move(tree);
  make_room(grid, graph_scratch, graph, borders, border_merging, paper_merging);
  timings.merging = watch.lap();

  // One level of it labels every input point.
  const absl::StatusOr<Cut> level = cut(result.tree, options, stop);
  if (!level.ok()) return level.status();
  result.segments = level->segments;
  spread(grid, supervoxels, *level, options.threads, stop, labels, result);
  if (status = stop.check(); !status.ok()) return status;
  make_room(grid, labels);
  timings.labels = watch.lap();

  result.threshold = options.threshold;
  result.finite_points = grid.finite_points;
  result.segmented_points = std::accumulate(grid.points.begin(), grid.points.end(), std::size_t{0});
  result.voxels = grid.size();
  timings.total = total.lap();
  return result;
}

absl::StatusOr<Segmentation> segment(const CloudView& cloud, const Options& options, const StopToken& stop) {
  return Segmenter().segment(cloud, options, stop);
}

absl::Status describe(const CloudView& cloud, unsigned threads, const StopToken& stop, Segmentation& segmentation) {
  Stopwatch watch;
  const std::uint32_t segments = std::min(segmentation.segments, kMostDescribedSegments);
  auto statistics = describe_segments(cloud, segmentation.labels, segments, threads, stop);
  if (!statistics.ok()) return statistics.status();
  if (!segmentation.supervoxel_normals.empty()) {
    std::vector<std::uint32_t> segment_of_leaf(segmentation.supervoxel_normals.size());
    StopCheck(stop).for_each(0, cloud.size(), [&](std::size_t i) {
      const std::uint32_t supervoxel = segmentation.supervoxels[i];
      if (supervoxel > 0) segment_of_leaf[supervoxel - 1] = segmentation.labels[i];
    });
    if (absl::Status status = stop.check(); !status.ok()) return status;
    set_normals(segmentation.supervoxel_normals, segment_of_leaf, *statistics, stop);
    if (absl::Status status = stop.check(); !status.ok()) return status;
  }
  segmentation.statistics = *std::move(statistics);
  segmentation.timings.segments = watch.lap();
  segmentation.timings.total += segmentation.timings.segments;
  return absl::OkStatus();
}

}  // namespace segserve
