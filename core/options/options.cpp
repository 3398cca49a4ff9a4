// SPDX-License-Identifier: Apache-2.0
#include "segserve/options.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

#include "fmt/format.h"

namespace segserve {
namespace {

/// The defaults of a method.
struct MethodInfo {
  Method method;
  std::string_view name;
  double threshold;
  SupervoxelOptions supervoxels;
};

constexpr SupervoxelOptions kPaperSupervoxels{0.008, 0.08, 0.2, 0.4, 1.0};  // about 250 on an OSD frame
constexpr SupervoxelOptions kFittingSupervoxels{std::nullopt, std::nullopt, 0.0, 1.0, 4.0};

constexpr std::array kMethods = {
    MethodInfo{Method::kBorder, "border", 0.5, kFittingSupervoxels},
    MethodInfo{Method::kColor, "color", 0.10, kPaperSupervoxels},
    MethodInfo{Method::kGeometry, "geometry", 0.29, kPaperSupervoxels},
    MethodInfo{Method::kLambda, "lambda", 0.18, kPaperSupervoxels},
    MethodInfo{Method::kLambdaConvex, "lambda-convex", 0.15, kPaperSupervoxels},
    MethodInfo{Method::kEqualization, "equalization", 0.94, kPaperSupervoxels},
    MethodInfo{Method::kEqualizationConvex, "equalization-convex", 0.94, kPaperSupervoxels},
    MethodInfo{Method::kFixedLambda, "fixed-lambda", 0.18, kPaperSupervoxels},
};

constexpr std::array<std::string_view, 5> kPresets = {"auto", "tabletop", "room", "lidar", "scan"};

const MethodInfo& info(Method method) { return kMethods[static_cast<std::size_t>(method)]; }
bool is_method(Method method) { return static_cast<std::size_t>(method) < kMethods.size(); }
bool is_preset(Preset preset) { return static_cast<std::size_t>(preset) < kPresets.size(); }

/// An option that is a double or an optional double.
template <auto member>
constexpr OptionInfo number(std::string_view name, std::string_view unit, std::string_view description, double minimum,
                            double maximum) {
  return {name,
          unit,
          description,
          minimum,
          maximum,
          false,
          [](const Options& o) { return std::optional<double>(o.*member); },
          [](Options& o, double value) { o.*member = value; }};
}

/// An option that is a whole number or an optional whole number.
template <auto member>
constexpr OptionInfo whole(std::string_view name, std::string_view description, double minimum, double maximum) {
  return {name,
          "",
          description,
          minimum,
          maximum,
          true,
          [](const Options& o) {
            const std::optional<std::uint32_t> value = o.*member;
            return value ? std::optional<double>(*value) : std::nullopt;
          },
          [](Options& o, double value) { o.*member = static_cast<std::uint32_t>(value); }};
}

constexpr double kFarthest = 100'000;
/// Meters. Coordinates may be those of the earth, such as UTM.
constexpr double kFarthestSide = 100'000'000;

constexpr std::array kTable = {
    number<&Options::voxel_resolution>("voxel_resolution", "m", "edge of a voxel; in a CAMERA view at 1 m distance",
                                       0.001, 1),
    number<&Options::seed_resolution>(
        "seed_resolution", "m", "distance between the seeds of supervoxels; not below voxel_resolution", 0.002, 10),
    number<&Options::color_weight>("color_weight", "", "weight of color in the supervoxel distance", 0, 100),
    number<&Options::spatial_weight>("spatial_weight", "", "weight of position in the supervoxel distance", 0, 100),
    number<&Options::normal_weight>("normal_weight", "", "weight of the normals in the supervoxel distance", 0, 100),
    number<&Options::lambda>("lambda", "", "weight of color against geometry, for fixed-lambda", 0, 1),
    number<&Options::threshold>("threshold", "", "cut the merge tree where the dissimilarity reaches this", 0, 1),
    whole<&Options::regions>("regions", "cut the merge tree at this number of regions instead of a threshold", 1,
                             2147483647),
    whole<&Options::min_segment_points>(
        "min_segment_points", "segments of fewer points join the neighbor they are least unlike", 0, 2147483647),
    number<&Options::crop_min_x>("crop_min_x", "m", "leave out points with a smaller x", -kFarthestSide, kFarthestSide),
    number<&Options::crop_max_x>("crop_max_x", "m", "leave out points with a greater x", -kFarthestSide, kFarthestSide),
    number<&Options::crop_min_y>("crop_min_y", "m", "leave out points with a smaller y", -kFarthestSide, kFarthestSide),
    number<&Options::crop_max_y>("crop_max_y", "m", "leave out points with a greater y", -kFarthestSide, kFarthestSide),
    number<&Options::crop_min_z>("crop_min_z", "m", "leave out points with a smaller z", -kFarthestSide, kFarthestSide),
    number<&Options::crop_max_z>("crop_max_z", "m", "leave out points with a greater z", -kFarthestSide, kFarthestSide),
    number<&Options::range_min>("range_min", "m", "leave out points nearer to the sensor", 0, kFarthest),
    number<&Options::range_max>("range_max", "m", "leave out points farther from the sensor", 0, kFarthest),
    number<&Options::support_plane_distance>(
        "support_plane_distance", "m",
        "remove the plane that supports the objects, with what is this near to it; in a CAMERA view at 1 m distance",
        0.001, 0.5),
    whole<&Options::threads>("threads", "threads within one call; the result does not depend on it", 1, 64),
};

template <typename Named>
std::string names_of(std::span<const Named> all) {
  std::string names;
  for (const Named each : all) names += fmt::format("{}{}", names.empty() ? "" : ", ", name(each));
  return names;
}

/// Adds a fault if the maximum is not above the minimum; either may be unset.
void check_interval(std::string_view minimum_name, const std::optional<double>& minimum, std::string_view maximum_name,
                    const std::optional<double>& maximum, std::vector<FieldViolation>& faults) {
  if (!minimum || !maximum || *minimum < *maximum) return;
  faults.push_back(
      {std::string(maximum_name), fmt::format("{} m is not above {}, {} m", *maximum, minimum_name, *minimum)});
}

/// Adds a fault if the preset and other options exclude each other.
void check_preset(const Options& options, std::vector<FieldViolation>& faults) {
  if (options.preset == Preset::kAuto) return;
  if (!is_preset(options.preset)) {
    faults.push_back({"preset", fmt::format("{} is no preset", static_cast<int>(options.preset))});
  } else if (options.method != Method::kBorder) {
    faults.push_back({"preset", fmt::format("'{}' is for the method border, not for {}", name(options.preset),
                                            name(options.method))});
  } else if (options.preset == Preset::kLidar && (options.voxel_resolution || options.seed_resolution)) {
    faults.push_back({"preset",
                      "'lidar' makes voxels as fine as the rays, so that voxel_resolution and "
                      "seed_resolution must be unset"});
  }
}

absl::Status as_status(const std::vector<FieldViolation>& faults) {
  if (faults.empty()) return absl::OkStatus();
  std::string message;
  for (const FieldViolation& fault : faults) {
    fmt::format_to(std::back_inserter(message), "{}{}: {}", message.empty() ? "" : "; ", fault.field,
                   fault.description);
  }
  return absl::InvalidArgumentError(message);
}

}  // namespace

std::string_view name(Method method) { return info(method).name; }

std::optional<Method> method_from_name(std::string_view name) {
  const auto* found = std::ranges::find(kMethods, name, &MethodInfo::name);
  return found == kMethods.end() ? std::nullopt : std::optional(found->method);
}

std::span<const Method> all_methods() {
  static constexpr auto kAll = [] {
    std::array<Method, kMethods.size()> all{};
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = kMethods[i].method;
    return all;
  }();
  return kAll;
}

std::string_view name(Preset preset) { return kPresets[static_cast<std::size_t>(preset)]; }

std::optional<Preset> preset_from_name(std::string_view name) {
  const auto* found = std::ranges::find(kPresets, name);
  return found == kPresets.end() ? std::nullopt : std::optional(static_cast<Preset>(found - kPresets.begin()));
}

std::span<const Preset> all_presets() {
  static constexpr std::array kAll = {Preset::kAuto, Preset::kTabletop, Preset::kRoom, Preset::kLidar, Preset::kScan};
  return kAll;
}

std::string method_names() { return names_of(all_methods()); }
std::string preset_names() { return names_of(all_presets()); }

double default_threshold(Method method) { return info(method).threshold; }

Options resolved(Options options) {
  const auto& [method, name, threshold, supervoxels] = info(options.method);
  const auto fill = [](std::optional<double>& value, std::optional<double> otherwise) {
    if (!value) value = otherwise;
  };
  fill(options.voxel_resolution, supervoxels.voxel_resolution);
  fill(options.seed_resolution, supervoxels.seed_resolution);
  fill(options.color_weight, supervoxels.color_weight);
  fill(options.spatial_weight, supervoxels.spatial_weight);
  fill(options.normal_weight, supervoxels.normal_weight);
  if (!options.regions) fill(options.threshold, threshold);
  return options;
}

SupervoxelOptions supervoxel_options(const Options& options) {
  const Options o = resolved(options);
  return {o.voxel_resolution, o.seed_resolution, *o.color_weight, *o.spatial_weight, *o.normal_weight};
}

std::span<const OptionInfo> option_table() { return kTable; }

std::optional<double> default_value(const OptionInfo& option, Method method) {
  return option.get(resolved({.method = method}));
}

std::optional<FieldViolation> violation(const OptionInfo& option, double value) {
  const bool in_range = value >= option.minimum && value <= option.maximum;  // NaN is in no range.
  if (in_range && (!option.whole || value == static_cast<double>(static_cast<std::int64_t>(value))))
    return std::nullopt;
  return FieldViolation{std::string(option.name),
                        fmt::format("{} is not {}in [{}, {}]{}{}", value, option.whole ? "a whole number " : "",
                                    option.minimum, option.maximum, option.unit.empty() ? "" : " ", option.unit)};
}

std::vector<FieldViolation> violations(const Options& options) {
  if (!is_method(options.method)) {
    return {{"method", fmt::format("{} is no method", static_cast<int>(options.method))}};
  }
  std::vector<FieldViolation> faults;
  for (const OptionInfo& option : kTable) {
    const std::optional<double> value = option.get(options);
    if (!value) continue;
    if (auto fault = violation(option, *value)) faults.push_back(*std::move(fault));
  }
  const SupervoxelOptions s = supervoxel_options(options);
  if (s.voxel_resolution && s.seed_resolution && *s.seed_resolution < *s.voxel_resolution) {
    faults.push_back({"seed_resolution",
                      fmt::format("{} m is below voxel_resolution, {} m", *s.seed_resolution, *s.voxel_resolution)});
  }
  if (s.color_weight == 0 && s.spatial_weight == 0 && s.normal_weight == 0) {
    faults.push_back({"color_weight", "color_weight, spatial_weight and normal_weight are all 0"});
  }
  if (options.threshold && options.regions) {
    faults.push_back({"regions", "threshold and regions exclude each other"});
  }
  check_preset(options, faults);
  check_interval("crop_min_x", options.crop_min_x, "crop_max_x", options.crop_max_x, faults);
  check_interval("crop_min_y", options.crop_min_y, "crop_max_y", options.crop_max_y, faults);
  check_interval("crop_min_z", options.crop_min_z, "crop_max_z", options.crop_max_z, faults);
  check_interval("range_min", options.range_min, "range_max", options.range_max, faults);
  return faults;
}

View segmented_view(const View& view, Preset preset) {
  if (preset == Preset::kTabletop) return View::camera();
  return preset == Preset::kLidar && !view.has_sensor() ? View::world(0, 0, 0) : view;
}

std::vector<FieldViolation> violations(const Options& options, const View& view) {
  std::vector<FieldViolation> faults;
  const bool is_elsewhere = view.sensor && *view.sensor != Eigen::Vector3f::Zero();
  if (options.preset == Preset::kTabletop && (is_elsewhere || !view.cameras.empty())) {
    faults.push_back({"preset",
                      "'tabletop' needs the frame of one camera, but the sensor of the cloud's view is not at "
                      "the origin"});
  }
  if (options.preset == Preset::kLidar && (view.kind == ViewKind::kCamera || !view.cameras.empty())) {
    faults.push_back({"preset", "'lidar' needs a WORLD view of one sensor, but the cloud's view is that of cameras"});
  }
  if (segmented_view(view, options.preset).has_sensor()) return faults;
  const auto need_sensor = [&faults](std::string_view name, const std::optional<double>& value) {
    if (value)
      faults.push_back({std::string(name), "the cloud has a WORLD view that does not say where its sensor is"});
  };
  need_sensor("range_min", options.range_min);
  need_sensor("range_max", options.range_max);
  return faults;
}

absl::Status check(const Options& options) { return as_status(violations(options)); }

absl::Status check(const Options& options, const View& view) {
  std::vector<FieldViolation> faults = violations(options);
  std::ranges::move(violations(options, view), std::back_inserter(faults));
  return as_status(faults);
}

}  // namespace segserve
