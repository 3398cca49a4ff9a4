// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/result_warnings.hpp"

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>

#include "fmt/format.h"

namespace segserve::wire {
namespace {

/// The field that tells lengths. Its name is the same in the API, in HTTP and, with dashes, on the command line.
constexpr std::string_view kUnit = "the unit of the coordinates (unit, or depth_scale of a depth image)";

/// Whether the points lie in so few voxels that they can hardly be a scene.
bool is_too_dense(const Segmentation& segmentation) {
  constexpr std::size_t kFewVoxels = 100, kManyPoints = 1000;
  constexpr std::size_t kHandful = 8, kEnoughPoints = 64;
  const std::size_t points = segmentation.segmented_points, voxels = segmentation.voxels;
  return (points >= kManyPoints && voxels < kFewVoxels) || (points >= kEnoughPoints && voxels < kHandful);
}

std::string too_sparse(const Segmentation& segmentation, const Resolution& used) {
  constexpr double kLargest = 1;  // meters; larger voxels cannot be asked for
  const double fitting = *segmentation.fitting_resolution;
  if (fitting > kLargest) {
    return fmt::format("the points are too far apart even for the largest voxels, of {:g} m: {} is probably wrong",
                       kLargest, kUnit);
  }
  std::string text = fmt::format(
      "nearly every voxel holds a single point ({} points, {} voxels): {} or voxel_resolution ({:g} m) is probably "
      "wrong; ",
      segmentation.segmented_points, segmentation.voxels, kUnit, used.voxel);
  return text + fmt::format("at {:g} m a voxel would hold four points or more, with a seed_resolution of {:g} m",
                            fitting, fitting * used.seed / used.voxel);
}

/// The median depth of the supervoxels of a CAMERA view, meters; 0 if there are none.
double median_depth(const Segmentation& segmentation) {
  std::vector<double> depths;
  depths.reserve(segmentation.supervoxel_features.size());
  for (const SupervoxelFeatures& feature : segmentation.supervoxel_features) depths.push_back(feature.centroid.z());
  if (depths.empty()) return 0;
  const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
  std::ranges::nth_element(depths, middle);
  return *middle;
}

/// Voxels of a CAMERA view grow with the depth and fit at any scale. Only the depths tell that a unit is wrong.
void warn_of_depths(const Segmentation& segmentation, std::vector<codec::Warning>& warnings) {
  constexpr double kNearest = 0.02, kFarthest = 150;  // meters, of what depth cameras see
  const double depth = median_depth(segmentation);
  if (depth == 0 || (depth >= kNearest && depth <= kFarthest)) return;
  warnings.push_back({depth > kFarthest ? codec::WarningReason::kTooSparse : codec::WarningReason::kTooDense,
                      fmt::format("half of the scene is {} than {:.3g} m from the camera: {} is probably wrong",
                                  depth > kFarthest ? "farther" : "nearer", depth, kUnit)});
}

}  // namespace

std::vector<codec::Warning> warnings_of(const Segmentation& segmentation, ViewKind view) {
  using codec::WarningReason;
  std::vector<codec::Warning> warnings;
  if (const std::size_t zeros = segmentation.zero_points; zeros > 0) {
    const bool is_sweep = segmentation.resolution.reason == ResolutionReason::kSweep;
    const char* const where = is_sweep ? "within 10 cm of the LiDAR" : "at (0, 0, 0), where the camera is,";
    warnings.push_back(
        {WarningReason::kPointsNotUsed, fmt::format("{} point{} {} {} no measurement{}", zeros, zeros == 1 ? "" : "s",
                                                    where, zeros == 1 ? "is" : "are", zeros == 1 ? "" : "s")});
  }
  if (const std::size_t far = segmentation.points_beyond_grid; far > 0) {
    warnings.push_back({WarningReason::kPointsNotUsed, fmt::format("{} point{} far beyond the others {} not used", far,
                                                                   far == 1 ? "" : "s", far == 1 ? "is" : "are")});
  }
  if (!segmentation.unfit_preset.empty()) {
    warnings.push_back({WarningReason::kPresetNotFit, std::string(segmentation.unfit_preset)});
  }
  const Resolution& used = segmentation.resolution;
  if (segmentation.segmented_points == 0) {
    warnings.push_back({WarningReason::kNoPoints,
                        "no point was segmented: all of them are not finite, no measurements, or outside the crop box "
                        "or the range"});
  } else if (is_too_dense(segmentation)) {
    warnings.push_back({WarningReason::kTooDense,
                        fmt::format("{} points lie in {} voxel{}: {} or voxel_resolution ({:g} m) is probably wrong",
                                    segmentation.segmented_points, segmentation.voxels,
                                    segmentation.voxels == 1 ? "" : "s", kUnit, used.voxel)});
  } else if (segmentation.fitting_resolution) {
    warnings.push_back({WarningReason::kTooSparse, too_sparse(segmentation, used)});
  } else if (view == ViewKind::kCamera) {
    warn_of_depths(segmentation, warnings);
  }
  return warnings;
}

}  // namespace segserve::wire
