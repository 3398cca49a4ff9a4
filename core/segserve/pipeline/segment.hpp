#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "segserve/cloud/cloud.hpp"
#include "segserve/options/options.hpp"
#include "segserve/pipeline/stop_token.hpp"
#include "segserve/tree/merge_tree.hpp"

namespace segserve {

/// Wall time of each stage, milliseconds.
struct StageTimings {
  double voxels = 0;       ///< voxelisation of the points
  double normals = 0;      ///< voxel adjacency and normals
  double supervoxels = 0;  ///< seeds and growth (VCCS)
  double graph = 0;        ///< region features, region adjacency graph
  double merging = 0;      ///< weights and the merge tree
  double labels = 0;       ///< cut, labels of the input points
  double total = 0;
};

/// A segmented cloud of N points and m supervoxels.
struct Segmentation {
  std::vector<std::uint32_t> labels;       ///< N, input order; 0 = not finite, 1..segments by descending size
  std::vector<std::uint32_t> supervoxels;  ///< N, input order; 0 = not finite, 1..m
  MergeTree tree;                          ///< the whole hierarchy; cut it anew without segmenting again
  std::uint32_t segments = 0;
  std::size_t finite_points = 0;
  std::size_t voxels = 0;
  std::optional<double> threshold;  ///< of the cut; unset if the caller asked for a number of regions
  double lambda = 0;  ///< weight of colour that was used; of the paper's methods only (1/2 for Equalization)
  StageTimings timings;
};

/// Segments clouds one after the other and keeps its buffers between calls. One thread at a time
/// may use an object; the result is a pure function of cloud and options.
class Segmenter {
 public:
  Segmenter();
  ~Segmenter();
  Segmenter(Segmenter&&) noexcept;
  Segmenter& operator=(Segmenter&&) noexcept;

  /// Errors: INVALID_ARGUMENT (options; shape; a CAMERA point with z <= 0; a coordinate beyond the
  /// grid), CANCELLED, DEADLINE_EXCEEDED. A cloud without any finite point is no error: all labels
  /// are 0 and the tree is empty.
  absl::StatusOr<Segmentation> segment(const CloudView& cloud, const Options& options, const StopToken& stop = {});

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

/// The same for a single cloud.
absl::StatusOr<Segmentation> segment(const CloudView& cloud, const Options& options, const StopToken& stop = {});

}  // namespace segserve
