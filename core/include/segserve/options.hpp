// SPDX-License-Identifier: Apache-2.0
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

/// The dissimilarity by which regions are merged: the border method, which is our own, and the rows of the paper's
/// Table 1.
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

/// The name of a method, as on the command line and in the API.
std::string_view name(Method method);
/// The method with this name; nullopt if there is none.
std::optional<Method> method_from_name(std::string_view name);
std::span<const Method> all_methods();
/// Their names, with commas between them, for messages.
std::string method_names();

/// What kind of cloud it is, for those who know better than the cloud can tell. Only the border method takes one.
enum class Preset : std::uint8_t {
  kAuto,  ///< "auto": the view, and the points, decide
  /// "tabletop": the frame of a camera, also if its file does not say so. The view becomes CAMERA.
  kTabletop,
  /// "room": rooms that were scanned or fused from the inside. Surfaces that close face inwards. A camera's frame stays
  /// one.
  kRoom,
  /// "lidar": one turn of a spinning LiDAR. The sensor is at the origin unless the view says where it is, and voxels
  /// are those of a panorama, however dense the points are.
  kLidar,
  /// "scan": things or buildings that were scanned from all around. Surfaces that close face outwards. A camera's frame
  /// stays one.
  kScan,
};

/// The name of a preset, as on the command line and in the API.
std::string_view name(Preset preset);
/// The preset with this name; nullopt if there is none.
std::optional<Preset> preset_from_name(std::string_view name);
std::span<const Preset> all_presets();
/// Their names, with commas between them, for messages.
std::string preset_names();

/// The options of a segmentation. An option that is unset takes the method's default (`resolved`). `option_table` holds
/// the units and ranges of all options.
struct Options {
  Method method = Method::kBorder;
  Preset preset = Preset::kAuto;
  /// Edge of a voxel, meters. In a CAMERA view it is the edge at 1 m distance, and grows in proportion to z. If it is
  /// unset, the border method takes one that fits the cloud (Segmentation::resolution).
  std::optional<double> voxel_resolution = std::nullopt;
  /// Distance between the seeds of supervoxels, meters. With the border method in a CAMERA view it is the distance at
  /// 1 m, and grows in proportion to z. If it is unset, the border method takes four times the edge of a voxel.
  std::optional<double> seed_resolution = std::nullopt;
  /// Weights of the three terms of the supervoxel distance (VCCS): the RGB distance over 255, the Euclidean distance
  /// over the seed resolution, and 1 - |cos| of the angle between the normals.
  std::optional<double> color_weight = std::nullopt;
  std::optional<double> spatial_weight = std::nullopt;
  std::optional<double> normal_weight = std::nullopt;
  /// Weight of color against geometry for `fixed-lambda`, [0, 1].
  double lambda = 0.5;
  /// The merge tree is cut where the weight reaches this, [0, 1].
  std::optional<double> threshold = std::nullopt;
  /// The merge tree is cut at this number of regions instead. It excludes `threshold`.
  std::optional<std::uint32_t> regions = std::nullopt;
  /// A segment of fewer input points joins the neighbor that it is least unlike, if it has one.
  std::uint32_t min_segment_points = 0;
  /// The crop box is a closed box along the axes of the cloud's own frame, meters. A side that is unset is open. A
  /// point outside counts as one that is not finite: it gets label 0 and has no influence on anything.
  std::optional<double> crop_min_x = std::nullopt, crop_max_x = std::nullopt;
  std::optional<double> crop_min_y = std::nullopt, crop_max_y = std::nullopt;
  std::optional<double> crop_min_z = std::nullopt, crop_max_z = std::nullopt;
  /// The closed range of distances from the sensor, meters. A point out of range counts as one outside the crop box. A
  /// WORLD view must say where its sensor is.
  std::optional<double> range_min = std::nullopt, range_max = std::nullopt;
  /// If set, the plane that supports the objects (SupportPlane) is removed: its points, which are at most this far from
  /// it, get label 0, and everything else is as if they were not finite. The distance is in meters. In a CAMERA view it
  /// is the distance at 1 m, and grows in proportion to z, as the depth noise does.
  std::optional<double> support_plane_distance = std::nullopt;
  /// Number of threads within one call, [1, 64], of which no more run than there are cores, and in a server no more
  /// than it allows. The result does not depend on it.
  std::uint32_t threads = 1;

  bool operator==(const Options&) const = default;
};

/// The options with the method's defaults for options that are unset. `threshold` stays unset if `regions` is set.
Options resolved(Options options);

/// The method's default threshold: 0.5 for `border`, and the one in the paper's Table 1 for the others.
double default_threshold(Method method);

/// The options of voxels and supervoxels, resolved; see Options.
struct SupervoxelOptions {
  std::optional<double> voxel_resolution, seed_resolution;  ///< meters; unset where the cloud decides
  double color_weight, spatial_weight, normal_weight;
};
SupervoxelOptions supervoxel_options(const Options& options);

/// A numeric option: its name (the same on the command line, in the API and in messages), its unit ("" if it has none),
/// its meaning, its closed range, and access to its value.
struct OptionInfo {
  std::string_view name;
  std::string_view unit;
  std::string_view description;
  double minimum;
  double maximum;
  bool whole;                                    ///< whether it takes whole numbers only
  std::optional<double> (*get)(const Options&);  ///< nullopt if the option is unset
  void (*set)(Options&, double);                 ///< the value must have no `violation`
};

/// All numeric options, for `--help`, the API and `violations`.
std::span<const OptionInfo> option_table();

/// The value of an option that is unset, with this method; nullopt if the option is off by default.
std::optional<double> default_value(const OptionInfo& option, Method method);

/// A fault of one option.
struct FieldViolation {
  std::string field;        ///< the name of the option
  std::string description;  ///< what is wrong with its value, and what is allowed
  bool operator==(const FieldViolation&) const = default;
};

/// The fault of a value of one option: it is out of range, or not whole. nullopt if the option can take the value.
std::optional<FieldViolation> violation(const OptionInfo& option, double value);

/// All faults of the options; empty if they are valid.
std::vector<FieldViolation> violations(const Options& options);

/// The view in which a cloud with this view is segmented: CAMERA with kTabletop; with kLidar a WORLD view without a
/// sensor gets one at the origin; else the same view.
View segmented_view(const View& view, Preset preset);

/// The faults that options, valid in themselves, have for a cloud in this view: a range needs a known sensor, kTabletop
/// none elsewhere than at the origin, and kLidar a WORLD view of a single sensor.
std::vector<FieldViolation> violations(const Options& options, const View& view);

/// The faults of the options as a status: INVALID_ARGUMENT that names every wrong option, or OK.
absl::Status check(const Options& options);
/// The same, with the faults for a cloud in this view.
absl::Status check(const Options& options, const View& view);

}  // namespace segserve
