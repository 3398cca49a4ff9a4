// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"
#include "segserve/options.hpp"
#include "segserve/segment.hpp"
#include "segserve/segment_statistics.hpp"
#include "segserve/selection.hpp"
#include "segserve/stop_token.hpp"

// Objects that someone points at: prompts become supervoxels, by which `select` finds nodes of the merge tree.
namespace segserve {

/// A pixel of an organized cloud, counted from the upper left, from 0.
struct Pixel {
  std::uint32_t column = 0;
  std::uint32_t row = 0;
  bool operator==(const Pixel&) const = default;
};

/// A place that someone points at: a position in the frame of the cloud, meters, or a pixel.
using Prompt = std::variant<Eigen::Vector3d, Pixel>;

/// Places on an object, and places beside it.
struct Prompts {
  std::vector<Prompt> include = {};  ///< at least one
  std::vector<Prompt> exclude = {};
  /// The candidate (see Selection) that the cut makes is taken, or one that is larger by so many steps. Below 0 it is
  /// smaller. Beyond the ends it is the largest or the smallest.
  std::int32_t larger = 0;
  bool operator==(const Prompts&) const = default;
};

/// The most places of one kind that are accepted from others.
inline constexpr std::size_t kMostPrompts = 64;

/// Every fault that can be told without the cloud: nothing is included, there are too many places, or a position is not
/// finite. Fields are "include", "exclude[2]" and their like.
std::vector<FieldViolation> violations(const Prompts& prompts);

/// The segmented point that a place stands for.
struct PromptedPoint {
  std::size_t point = 0;         ///< its index in the cloud
  std::uint32_t supervoxel = 0;  ///< of the point, from 1
  double distance = 0;           ///< from the position, meters; 0 for a pixel
  bool operator==(const PromptedPoint&) const = default;
};

/// The selected segment, and the others that could have been selected.
struct PromptedSelection {
  std::vector<PromptedPoint> include, exclude;  ///< in the order of the prompts
  Selection selection;
  std::size_t candidate = 0;          ///< the one that is taken
  ThresholdRange thresholds;          ///< of the candidate
  std::vector<std::uint32_t> labels;  ///< N, 1 for each point that is selected, 0 for the others
  /// Statistics of the points that are selected, without a normal. Unset unless `describe` sets it.
  std::optional<SegmentStatistics> statistics;
  bool operator==(const PromptedSelection&) const = default;
};

/// Selects by places in a cloud of N points that was segmented. A position stands for the nearest point that is
/// segmented, and for the first of them if several are equally near. The candidate is that of the cut at
/// `segmentation.threshold`, or to `regions` if that is set. O(N) for each position.
///
/// INVALID_ARGUMENT names every place that stands for no point, because the cloud is no image, has no such pixel, or
/// the point there is not segmented. It also says that nothing is included, or that one supervoxel is included and
/// excluded. CANCELLED, DEADLINE_EXCEEDED.
absl::StatusOr<PromptedSelection> select_by_prompts(const CloudView& cloud, const Segmentation& segmentation,
                                                    std::optional<std::uint32_t> regions, const Prompts& prompts,
                                                    const StopToken& stop = {});

/// Sets the statistics of what was selected in this cloud. Errors are those of describe_segments.
absl::Status describe(const CloudView& cloud, unsigned threads, const StopToken& stop, PromptedSelection& selected);

}  // namespace segserve
