#include "segserve/options/options.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "fmt/format.h"

namespace segserve {
namespace {

struct MethodInfo {
  Method method;
  std::string_view name;
  double threshold;  // learnt by the paper (Table 1); fixed-lambda takes that of Adaptive Lambda
};

constexpr std::array kMethods = {
    MethodInfo{Method::kColor, "color", 0.10},
    MethodInfo{Method::kGeometry, "geometry", 0.29},
    MethodInfo{Method::kLambda, "lambda", 0.18},
    MethodInfo{Method::kLambdaConvex, "lambda-convex", 0.15},
    MethodInfo{Method::kEqualization, "equalization", 0.94},
    MethodInfo{Method::kEqualizationConvex, "equalization-convex", 0.94},
    MethodInfo{Method::kFixedLambda, "fixed-lambda", 0.18},
};

const MethodInfo& info(Method method) { return kMethods[static_cast<std::size_t>(method)]; }

/// An option together with the place where it is kept: nullopt means "not given", which is valid.
struct OptionEntry {
  OptionInfo info;
  std::optional<double> (*get)(const Options&);
};

constexpr Options kDefaults;

constexpr std::array kEntries = {
    OptionEntry{{"voxel_resolution", "m", "edge of a voxel; in a CAMERA view at 1 m distance", 0.001, 1.0,
                 kDefaults.voxel_resolution},
                [](const Options& o) { return std::optional<double>(o.voxel_resolution); }},
    OptionEntry{{"seed_resolution", "m", "distance between the seeds of supervoxels; not below voxel_resolution", 0.002,
                 10.0, kDefaults.seed_resolution},
                [](const Options& o) { return std::optional<double>(o.seed_resolution); }},
    OptionEntry{{"color_weight", "", "weight of colour in the supervoxel distance", 0.0, 100.0, kDefaults.weights.color},
                [](const Options& o) { return std::optional<double>(o.weights.color); }},
    OptionEntry{{"spatial_weight", "", "weight of position in the supervoxel distance", 0.0, 100.0,
                 kDefaults.weights.spatial},
                [](const Options& o) { return std::optional<double>(o.weights.spatial); }},
    OptionEntry{{"normal_weight", "", "weight of the normals in the supervoxel distance", 0.0, 100.0,
                 kDefaults.weights.normal},
                [](const Options& o) { return std::optional<double>(o.weights.normal); }},
    OptionEntry{{"lambda", "", "weight of colour against geometry, for fixed-lambda", 0.0, 1.0, kDefaults.lambda},
                [](const Options& o) { return std::optional<double>(o.lambda); }},
    OptionEntry{{"threshold", "", "cut the merge tree where the dissimilarity reaches this; default by method", 0.0, 1.0,
                 std::nullopt},
                [](const Options& o) { return o.threshold; }},
    OptionEntry{{"regions", "", "cut the merge tree at this number of regions instead of a threshold", 1.0, 2147483647.0,
                 std::nullopt},
                [](const Options& o) {
                  return o.regions ? std::optional<double>(*o.regions) : std::optional<double>();
                }},
    OptionEntry{{"threads", "", "threads within one call; the result does not depend on it", 1.0, 64.0,
                 kDefaults.threads},
                [](const Options& o) { return std::optional<double>(o.threads); }},
};

constexpr auto kTable = [] {
  std::array<OptionInfo, kEntries.size()> table{};
  for (std::size_t i = 0; i < table.size(); ++i) table[i] = kEntries[i].info;
  return table;
}();

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

double default_threshold(Method method) { return info(method).threshold; }

std::span<const OptionInfo> option_table() { return kTable; }

std::vector<FieldViolation> violations(const Options& options) {
  std::vector<FieldViolation> faults;
  for (const auto& [option, get] : kEntries) {
    const std::optional<double> value = get(options);
    if (!value || (*value >= option.minimum && *value <= option.maximum)) continue;  // a NaN is in no range
    faults.push_back({std::string(option.name), fmt::format("{} is not in [{}, {}]{}{}", *value, option.minimum,
                                                            option.maximum, option.unit.empty() ? "" : " ", option.unit)});
  }
  if (static_cast<std::size_t>(options.method) >= kMethods.size()) {
    faults.push_back({"method", fmt::format("{} is no method", static_cast<int>(options.method))});
  }
  if (options.seed_resolution < options.voxel_resolution) {
    faults.push_back({"seed_resolution", fmt::format("{} m is below voxel_resolution, {} m", options.seed_resolution,
                                                     options.voxel_resolution)});
  }
  if (options.weights.color == 0 && options.weights.spatial == 0 && options.weights.normal == 0) {
    faults.push_back({"color_weight", "color_weight, spatial_weight and normal_weight are all 0"});
  }
  if (options.threshold && options.regions) {
    faults.push_back({"regions", "threshold and regions exclude each other"});
  }
  return faults;
}

absl::Status check(const Options& options) {
  const std::vector<FieldViolation> faults = violations(options);
  if (faults.empty()) return absl::OkStatus();
  std::string message;
  for (const FieldViolation& fault : faults) {
    fmt::format_to(std::back_inserter(message), "{}{}: {}", message.empty() ? "" : "; ", fault.field, fault.description);
  }
  return absl::InvalidArgumentError(message);
}

}  // namespace segserve
