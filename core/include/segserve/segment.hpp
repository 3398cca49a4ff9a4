// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"
#include "segserve/merge_tree.hpp"
#include "segserve/options.hpp"
#include "segserve/resolution.hpp"
#include "segserve/segment_statistics.hpp"
#include "segserve/stop_token.hpp"
#include "segserve/support_plane.hpp"

namespace segserve {

/// Wall time of each stage, milliseconds.
struct StageTimings {
  double voxels = 0;       ///< voxelization of the points
  double normals = 0;      ///< voxel adjacency, removal of the support plane, normals
  double supervoxels = 0;  ///< seeds and growth (VCCS)
  double graph = 0;        ///< region features, region adjacency graph
  double merging = 0;      ///< weights, points at borders, and the merge tree
  double labels = 0;       ///< cut of the merge tree, labels of the points
  double tracking = 0;     ///< ids of the segments over time, by whoever calls `track`
  double segments = 0;     ///< statistics of the segments, by `describe`
  double total = 0;
};

/// The place and appearance of a supervoxel, in the frame of the cloud.
struct SupervoxelFeatures {
  double voxels = 0;                                   ///< their number
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();  ///< mean of the centroids of the voxels, meters
  Eigen::Vector3d color = Eigen::Vector3d::Zero();     ///< mean of (R, G, B) of the points, 0..255; 0 without color
  bool operator==(const SupervoxelFeatures&) const = default;
};

/// A segmented cloud of N points and m supervoxels. A point is not segmented if it is not finite, if the crop box or
/// the range leaves it out, if it is removed with the support plane, or if it is no measurement: (0, 0, 0) in a CAMERA
/// view, or one of a few points that lie far beyond the others.
struct Segmentation {
  std::vector<std::uint32_t> labels;       ///< N, input order; 0 = not segmented, 1..segments by descending size
  std::vector<std::uint32_t> supervoxels;  ///< N, input order; 0 = not segmented, 1..m
  MergeTree tree;                          ///< the whole hierarchy, which can be cut anew without segmenting again
  std::uint32_t segments = 0;              ///< number of segments
  bool is_cut = true;                      ///< whether the segments are a cut of the tree at one height (see `apply`)
  /// Statistics of the kMostDescribedSegments largest segments, largest first. Empty unless `describe` sets them.
  std::vector<SegmentStatistics> statistics;
  std::vector<Eigen::Vector3d> supervoxel_normals;      ///< m: sums of the unit normals of each supervoxel's voxels
  std::vector<SupervoxelFeatures> supervoxel_features;  ///< m: what `track` needs (segserve/tracking.hpp)
  std::size_t finite_points = 0;       ///< points that are finite, segmented or not; zero_points do not count
  std::size_t zero_points = 0;         ///< points at (0, 0, 0) in a CAMERA view, or within 10 cm of a sweep's sensor
  std::size_t points_beyond_grid = 0;  ///< finite points that were left out because they are beyond the grid
  std::size_t segmented_points = 0;    ///< points with a label other than 0
  std::optional<SupportPlane> support_plane;  ///< set if the options ask for its removal
  std::size_t voxels = 0;                     ///< voxels that were segmented
  /// Set if nearly every voxel holds a single point, or if even voxels of 1 m are too fine for the cloud: an edge of
  /// voxels, meters, that would fit. The resolution, or the unit of the coordinates, is then probably wrong.
  std::optional<double> fitting_resolution;
  Resolution resolution;  ///< of voxels and supervoxels, and why
  /// Why the preset of the options had no effect, as a line for people: no sweep can be seen in the points, or the
  /// cloud is a camera's frame. Empty if it had one.
  std::string_view unfit_preset;
  std::optional<double> threshold;  ///< of the cut; unset if the options ask for a number of regions
  /// The weight of color against geometry that a method of the paper used; 1/2 for Equalization. 0 with the border
  /// method, which has no such weight.
  double lambda = 0;
  StageTimings timings;
};

/// How large a frame is: while its voxels are counted, each time that their number has doubled, and once all are
/// counted.
struct FrameSize {
  std::size_t points = 0;             ///< of the cloud
  std::size_t voxels = 0;             ///< that have been found
  std::uint64_t workspace_bytes = 0;  ///< at most so much memory is needed for them beyond the cloud
  /// A voxel_resolution, meters, at which the cloud would fill at most so many voxels (at least 1). It is the
  /// resolution of the frame times a power of two. Only valid during the call of the Admission.
  std::function<double(std::size_t voxels)> resolution_for;
};

/// Decides whether a frame of this size is segmented. A status other than OK ends the segmentation with that status.
using Admission = std::function<absl::Status(const FrameSize& size)>;

/// The memory that Segmenter::segment needs before it asks its Admission for the first time, and the most that it needs
/// for a cloud of so many voxels, bytes. Both are beyond the cloud and include the result.
/// test/core/pipeline/memory_test.cpp measures them.
std::uint64_t voxelization_bytes(std::uint64_t points);
std::uint64_t workspace_bytes(std::uint64_t points, std::uint64_t voxels);

/// Segments clouds one after the other. It keeps its buffers and threads between calls, so that a frame takes less time
/// than with `segment` below. One thread at a time may use an object. The result depends on nothing but the cloud and
/// the options, whatever was segmented before.
///
///     Segmenter segmenter;
///     for (const Cloud& cloud : frames) {
///       absl::StatusOr<Segmentation> result = segmenter.segment(cloud, {.threads = 2});
///       if (!result.ok()) return result.status();
///       use(result->labels);
///     }
class Segmenter {
 public:
  Segmenter();
  ~Segmenter();
  Segmenter(Segmenter&&) noexcept;
  Segmenter& operator=(Segmenter&&) noexcept;

  /// Segments a cloud. A cloud without any point to segment is no error: all labels are 0 and the tree is empty.
  /// INVALID_ARGUMENT if the options are not valid (`check`), the cloud has the wrong shape (`check_shape`), or more
  /// than a few points to segment have z <= 0 in a CAMERA view or lie beyond the grid, which reaches about 2^18 voxels
  /// from the origin. Points at (0, 0, 0) in a CAMERA view, and a few beyond the grid, are left out.
  /// CANCELLED and DEADLINE_EXCEEDED as `stop` says. An exception of a WorkMeter's callback, or std::bad_alloc, leaves
  /// the object in a state in which it can segment other clouds. `admit` is asked as FrameSize says, before the
  /// memory is allocated.
  absl::StatusOr<Segmentation> segment(const CloudView& cloud, const Options& options, const StopToken& stop = {},
                                       const Admission& admit = nullptr);

 private:
  struct Workspace;
  absl::StatusOr<Segmentation> segment_within(const CloudView& cloud, const Options& options, const StopToken& stop,
                                              const Admission& admit);

  std::unique_ptr<Workspace> workspace_;
};

/// Segments a single cloud; see Segmenter::segment.
absl::StatusOr<Segmentation> segment(const CloudView& cloud, const Options& options, const StopToken& stop = {});

/// Sets the statistics of a segmentation of this cloud, and the time that this took. They have normals if the
/// segmentation has those of its supervoxels, and thresholds if it has the tree. The segmentation does not change
/// unless OK is returned. Errors are those of describe_segments.
absl::Status describe(const CloudView& cloud, unsigned threads, const StopToken& stop, Segmentation& segmentation);

}  // namespace segserve
