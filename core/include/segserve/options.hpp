#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "segserve/cloud.hpp"

namespace segserve {

/// The dissimilarity by which regions are merged, by name: ours, and the rows of the paper's Table 1.
enum class Method : std::uint8_t {
  kBorder,              ///< "border": evidence along the borders of supervoxels, on edge-aware normals
  kColor,               ///< "color": delta_C alone (eq. 4)
  kGeometry,            ///< "geometry": delta_G alone (eq. 5)
  kLambda,              ///< "lambda": Adaptive Lambda with delta_G
  kLambdaConvex,        ///< "lambda-convex": Adaptive Lambda with delta'_G (eq. 7)
  kEqualization,        ///< "equalization": Equalization with delta_G
  kEqualizationConvex,  ///< "equalization-convex": Equalization with delta'_G
  kFixedLambda,         ///< "fixed-lambda": lambda delta_C + (1 - lambda) delta_G
};

std::string_view name(Method method);
std::optional<Method> method_from_name(std::string_view name);
std::span<const Method> all_methods();

/// What a caller may ask for. What is unset takes the method's default (`resolved`). Units and ranges are in
/// `option_table`.
struct Options {
  Method method = Method::kBorder;
  /// Edge of a voxel: metres in a WORLD view; in a CAMERA view metres at 1 m distance.
  std::optional<double> voxel_resolution = std::nullopt;
  /// Distance between the seeds of supervoxels, metres.
  std::optional<double> seed_resolution = std::nullopt;
  /// Weights of the supervoxel distance (VCCS): of the RGB distance over 255, of the Euclidean distance over the
  /// seed resolution, and of 1 - |cos| of the angle between the normals.
  std::optional<double> color_weight = std::nullopt;
  std::optional<double> spatial_weight = std::nullopt;
  std::optional<double> normal_weight = std::nullopt;
  /// Weight of colour against geometry for `fixed-lambda`.
  double lambda = 0.5;
  /// Cut the merge tree where the weight reaches this, [0, 1].
  std::optional<double> threshold = std::nullopt;
  /// Cut the merge tree at this number of regions instead; excludes `threshold`.
  std::optional<std::uint32_t> regions = std::nullopt;
  /// A segment of fewer input points joins the neighbour it is least unlike, if it has any.
  std::uint32_t min_segment_points = 0;
  /// Crop box: a closed box along the axes of the cloud's own frame, metres; a side that is unset is open. A point
  /// outside counts as one that is not finite: it gets label 0 and has no influence on anything.
  std::optional<double> crop_min_x = std::nullopt, crop_max_x = std::nullopt;
  std::optional<double> crop_min_y = std::nullopt, crop_max_y = std::nullopt;
  std::optional<double> crop_min_z = std::nullopt, crop_max_z = std::nullopt;
  /// Closed range of distances from the sensor, metres; what is out of range counts as outside a crop box. A WORLD
  /// view must say where its sensor is.
  std::optional<double> range_min = std::nullopt, range_max = std::nullopt;
  /// Finds the plane that supports the objects (find_support_plane) and gives label 0 to its points, all that are
  /// at most this far from it: metres in a WORLD view; in a CAMERA view metres at 1 m distance, in proportion to z
  /// elsewhere, as depth noise grows. All else is as if these points were not finite. Unset: nothing is removed.
  std::optional<double> support_plane_distance = std::nullopt;
  /// Threads within one call; the result does not depend on it.
  std::uint32_t threads = 1;

  bool operator==(const Options&) const = default;
};

/// The options with the method's defaults in place of what is unset; `threshold` stays unset if `regions` is given.
Options resolved(Options options);

/// The method's default threshold: 0.5 for `border`, that of the paper's Table 1 for the others.
double default_threshold(Method method);

/// The settings of the supervoxels, resolved.
struct SupervoxelOptions {
  double voxel_resolution, seed_resolution;  // metres
  double color_weight, spatial_weight, normal_weight;
};
SupervoxelOptions supervoxel_options(const Options& options);

/// One numeric option: its name (the same on the command line, in the API and in messages), what it means, its
/// unit ("" if none), its closed range, and where it is kept.
struct OptionInfo {
  std::string_view name;
  std::string_view unit;
  std::string_view description;
  double minimum;
  double maximum;
  bool whole;  ///< takes whole numbers only
  std::optional<double> (*get)(const Options&);
  void (*set)(Options&, double);  ///< the value must be in range, and whole where that is needed
};

/// Every numeric option, for `--help`, the API and `violations`.
std::span<const OptionInfo> option_table();

/// What the option is with this method unless it is given; nothing for what is off then.
std::optional<double> default_value(const OptionInfo& option, Method method);

struct FieldViolation {
  std::string field;        ///< an option's name
  std::string description;  ///< what is wrong with its value, and what is allowed
  bool operator==(const FieldViolation&) const = default;
};

/// The fault of one value of one option: out of range, or not whole where that is needed.
std::optional<FieldViolation> violation(const OptionInfo& option, double value);

/// Every fault of the options at once; empty if they are valid.
std::vector<FieldViolation> violations(const Options& options);

/// What is wrong with options, valid in themselves, for a cloud in this view: a range without a known sensor.
std::vector<FieldViolation> violations(const Options& options, const View& view);

/// The same as a status: INVALID_ARGUMENT naming every wrong option, or OK.
absl::Status check(const Options& options);
absl::Status check(const Options& options, const View& view);

}  // namespace segserve
