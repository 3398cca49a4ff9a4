// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>
#include <vector>

#include "core/base/executor.hpp"
#include "core/base/frame_context.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
#include "core/base/stopwatch.hpp"
#include "core/border_points/point_reassignment.hpp"
#include "core/labels/point_labeling.hpp"
#include "core/math/eigen_conversion.hpp"
#include "core/merging/border_merging.hpp"
#include "core/merging/paper_merging.hpp"
#include "core/normals/edge_aware_normals.hpp"
#include "core/normals/step_separation.hpp"
#include "core/normals/two_ring_normals.hpp"
#include "core/region_graph/region_graph.hpp"
#include "core/scale/scale_choice.hpp"
#include "core/supervoxels/seed_selection.hpp"
#include "core/supervoxels/supervoxel_growth.hpp"
#include "core/support_plane/support_plane_removal.hpp"
#include "core/voxels/coarser_resolution.hpp"
#include "core/voxels/component_bridging.hpp"
#include "core/voxels/seam.hpp"
#include "core/voxels/seeing_cameras.hpp"
#include "core/voxels/voxel_adjacency.hpp"
#include "core/voxels/voxel_positions.hpp"
#include "core/voxels/voxelization.hpp"
#include "segserve/segment.hpp"

namespace segserve {
namespace {

/// A frame with this many voxels is large: each stage frees its buffers when it has ended, because the buffers of all
/// stages together would take 500 bytes a voxel. The buffers of smaller frames are kept, which saves page faults.
constexpr std::size_t kManyVoxels = 250'000;
constexpr std::size_t kManyPoints = 1'000'000;

template <typename... Buffers>
void release_if(bool is_large, Buffers&... buffers) {
  if (is_large) ((buffers = Buffers()), ...);
}

absl::Status copy_features(const FrameContext& frame, const RegionGraph& graph, Segmentation& result) {
  result.supervoxel_normals.resize(graph.regions.size());
  result.supervoxel_features.resize(graph.regions.size());
  StopCheck check(frame.stop);
  check.for_each(0, graph.regions.size(), [&](std::size_t s) {
    const Region& region = graph.regions[s];
    result.supervoxel_normals[s] = to_eigen(region.normal_sum);
    result.supervoxel_features[s] = {.voxels = region.voxels,
                                     .centroid = to_eigen(region.centroid),
                                     .color = to_eigen((1.0 / region.points) * region.color_sum)};
  });
  return check.status();
}

absl::StatusOr<Cut> cut(const FrameContext& frame, const MergeTree& tree) {
  return frame.options.regions ? cut_to_regions(tree, *frame.options.regions, frame.stop)
                               : cut_at_threshold(tree, *frame.options.threshold, frame.stop);
}

/// Sets Segmentation::fitting_resolution if nearly every voxel holds a single point, and supervoxels are hardly larger.
absl::Status judge_resolution(const FrameContext& frame, Segmentation& result) {
  constexpr std::size_t kFewest = 16;    // A handful of points says nothing.
  constexpr double kSingle = 1.05;       // points of a voxel
  constexpr std::size_t kShattered = 2;  // voxels of a supervoxel
  constexpr std::size_t kWanted = 4;     // points of a voxel
  const bool is_sparse = static_cast<double>(result.segmented_points) < kSingle * static_cast<double>(result.voxels);
  const bool is_shattered = result.voxels < kShattered * result.tree.leaf_count();
  if (result.segmented_points < kFewest || !is_sparse || !is_shattered) return absl::OkStatus();
  result.fitting_resolution = coarser_resolution(frame, result.segmented_points / kWanted);
  return frame.stop.check();
}

Resolution resolution_of(const ChosenScale& chosen) {
  const VoxelScale& scale = chosen.scale;
  const bool is_known = scale.noise_depth < std::numeric_limits<double>::infinity();
  return {scale.voxel, scale.seed, chosen.reason, is_known ? std::optional(scale.noise_depth) : std::nullopt};
}

std::string_view unfit_preset(const FrameContext& frame, const ChosenScale& chosen) {
  switch (frame.options.preset) {
    case Preset::kAuto:
    case Preset::kTabletop:
      return "";
    case Preset::kRoom:
    case Preset::kScan:
      if (frame.view().kind == ViewKind::kWorld) return "";
      return "the cloud is the frame of a camera, on which the presets room and scan have no effect";
    case Preset::kLidar:
      if (chosen.reason == ResolutionReason::kSweep) return "";
      return "the points do not show the rings of a spinning LiDAR, so that the preset lidar has no effect";
  }
  return "";
}

absl::Status ask(const Admission& admit, const FrameContext& frame, std::size_t voxels) {
  FrameSize size;
  size.points = frame.cloud.size();
  size.voxels = voxels;
  size.workspace_bytes = workspace_bytes(size.points, size.voxels);
  size.resolution_for = [&](std::size_t most) { return coarser_resolution(frame, most); };
  return admit(size);
}

/// The most that choose_scale needs, which has given it back before the voxels are made.
std::uint64_t sampling_bytes(std::uint64_t points) {
  constexpr std::uint64_t kBytesPerPoint = 120, kMostPoints = 131'072;
  return kBytesPerPoint * std::min(points, kMostPoints);
}

}  // namespace

std::uint64_t voxelization_bytes(std::uint64_t points) {
  constexpr std::uint64_t kBytesPerVoxel = 500;
  return std::max(sampling_bytes(points),
                  12 * points + kBytesPerVoxel * std::min<std::uint64_t>(points, 2 * VoxelAdmission::kFirst));
}

std::uint64_t workspace_bytes(std::uint64_t points, std::uint64_t voxels) {
  constexpr std::uint64_t kLeast = 1 << 20;
  return kLeast + std::max(sampling_bytes(points), 12 * points + 1700 * voxels);
}

/// The stages with their buffers, and what they make of a frame.
struct Segmenter::Workspace {
  Executor& executor_with(unsigned threads) {
    if (executor.threads() != threads) executor = Executor(threads);
    return executor;
  }

  Executor executor{1};
  Voxelization voxelization;
  SupportPlaneRemoval support_plane_removal;
  EdgeAwareNormals edge_aware_normals;
  TwoRingNormals two_ring_normals;
  SeedSelection seed_selection;
  SupervoxelGrowth supervoxel_growth;
  RegionGraphConstruction region_graph_construction;
  BorderMerging border_merging;
  PointReassignment point_reassignment;
  PaperMerging paper_merging;
  PointLabeling point_labeling;

  VoxelGrid grid;
  VoxelAdjacency adjacency;
  std::vector<Vec3> normals;
  std::vector<Vec3> positions;
  Seeds seeds;
  Supervoxels supervoxels;
  RegionGraph graph;
  std::vector<ReassignedPoint> reassigned;
};

Segmenter::Segmenter() : workspace_(std::make_unique<Workspace>()) {}
Segmenter::~Segmenter() = default;
Segmenter::Segmenter(Segmenter&&) noexcept = default;
Segmenter& Segmenter::operator=(Segmenter&&) noexcept = default;

absl::StatusOr<Segmentation> Segmenter::segment(const CloudView& cloud, const Options& options, const StopToken& stop,
                                                const Admission& admit) {
  auto result = segment_within(cloud, options, stop, admit);
  // A large frame that ended early has not come to where its buffers are freed.
  const bool is_large = cloud.size() >= kManyPoints || workspace_->grid.size() >= kManyVoxels;
  if (!result.ok() && is_large) workspace_ = std::make_unique<Workspace>();
  return result;
}

absl::StatusOr<Segmentation> Segmenter::segment_within(const CloudView& cloud, const Options& options,
                                                       const StopToken& stop, const Admission& admit) {
  RETURN_IF_ERROR(check(options, cloud.view));
  RETURN_IF_ERROR(check_shape(cloud));
  Workspace& w = *workspace_;
  CloudView seen = cloud;
  seen.view = segmented_view(cloud.view, options.preset);
  FrameContext frame(seen, options, w.executor_with(options.threads), stop);
  ASSIGN_OR_RETURN(const ChosenScale chosen, choose_scale(frame));
  frame.scale = chosen.scale;
  const bool by_border = options.method == Method::kBorder;
  Segmentation result;
  StageTimings& timings = result.timings;
  Stopwatch total, watch;

  // The points, or those that the options select, become voxels.
  VoxelAdmission admission([&](std::size_t voxels) { return ask(admit, frame, voxels); });
  RETURN_IF_ERROR(w.voxelization.run(frame, w.grid, admit ? &admission : nullptr));
  RETURN_IF_ERROR(find_seeing_cameras(frame, w.grid));
  const bool is_large = w.grid.size() >= kManyVoxels;
  if (is_large) w.voxelization.free_scattered_tables();
  if (admit) RETURN_IF_ERROR(ask(admit, frame, w.grid.size()));
  timings.voxels = watch.lap();

  // Every voxel gets neighbors and a normal. The plane that supports the objects is removed before, if asked for.
  RETURN_IF_ERROR(find_adjacency(frame, w.grid, w.adjacency));
  if (frame.options.support_plane_distance) {
    RETURN_IF_ERROR(w.support_plane_removal.run(frame, w.grid, w.adjacency, result.support_plane.emplace()));
    release_if(is_large, w.support_plane_removal);
  }
  if (by_border) {
    RETURN_IF_ERROR(join_seam(frame, w.grid, w.adjacency));
    RETURN_IF_ERROR(bridge_components(frame, w.grid, {}, w.adjacency));
    RETURN_IF_ERROR(w.edge_aware_normals.run(frame, w.grid, w.adjacency, w.normals));
    RETURN_IF_ERROR(separate_steps(frame, w.grid, w.normals, w.adjacency));
  } else {
    RETURN_IF_ERROR(w.two_ring_normals.run(frame, w.grid, w.adjacency, w.normals));
  }
  release_if(is_large, w.edge_aware_normals, w.two_ring_normals);
  timings.normals = watch.lap();

  // Over-segmentation (section 2.1): the supervoxels R^m, by VCCS.
  RETURN_IF_ERROR(find_positions(frame, w.grid, w.positions));
  const std::vector<Vec3>& positions = w.positions.empty() ? w.grid.centroid : w.positions;
  RETURN_IF_ERROR(w.seed_selection.run(frame, positions, w.seeds));
  RETURN_IF_ERROR(w.supervoxel_growth.run(frame, w.grid, positions, w.adjacency, w.normals, w.seeds, w.supervoxels));
  release_if(is_large, w.seed_selection, w.seeds, w.supervoxel_growth);
  timings.supervoxels = watch.lap();

  // The region adjacency graph G^m (section 2.1).
  RETURN_IF_ERROR(w.region_graph_construction.run(frame, w.grid, w.adjacency, w.normals, w.supervoxels, w.graph));
  timings.graph = watch.lap();

  // The weights W^m of its edges (eq. 3 to 7); then the two most similar regions merge again and again (eq. 2), which
  // gives the dendrogram D. With the evidence of the border method, points at borders between objects find their side.
  w.reassigned.clear();
  if (by_border) {
    RETURN_IF_ERROR(w.border_merging.find_evidence(frame, w.grid, w.normals, w.supervoxels, w.graph));
    RETURN_IF_ERROR(w.point_reassignment.run(frame, w.grid, positions, w.adjacency, w.supervoxels,
                                             w.border_merging.evidence(), w.graph, w.reassigned));
  }
  release_if(is_large, w.positions, w.point_reassignment);
  RETURN_IF_ERROR(copy_features(frame, w.graph, result));
  RETURN_IF_ERROR(by_border ? w.border_merging.run(frame, w.graph, result.tree)
                            : w.paper_merging.run(frame, w.graph, result.tree, result.lambda));
  release_if(is_large, w.region_graph_construction, w.graph, w.border_merging, w.paper_merging);
  timings.merging = watch.lap();

  // A cut of the dendrogram labels every point.
  ASSIGN_OR_RETURN(const Cut level, cut(frame, result.tree));
  RETURN_IF_ERROR(
      w.point_labeling.run(frame, w.supervoxels, w.reassigned, level, w.grid, result.supervoxels, result.labels));
  release_if(is_large, w.point_labeling, w.reassigned);
  timings.labels = watch.lap();

  result.segments = level.segments;
  result.resolution = resolution_of(chosen);
  result.threshold = frame.options.threshold;
  result.unfit_preset = unfit_preset(frame, chosen);
  result.finite_points = w.grid.finite_points;
  result.segmented_points = std::accumulate(w.grid.points.begin(), w.grid.points.end(), std::size_t{0});
  result.voxels = w.grid.size();
  result.zero_points = w.grid.zero_points;
  result.points_beyond_grid = w.grid.points_beyond_grid;
  RETURN_IF_ERROR(judge_resolution(frame, result));
  if (chosen.fitting_voxel > 0) result.fitting_resolution = chosen.fitting_voxel;
  timings.total = total.lap();
  return result;
}

absl::StatusOr<Segmentation> segment(const CloudView& cloud, const Options& options, const StopToken& stop) {
  return Segmenter().segment(cloud, options, stop);
}

}  // namespace segserve
