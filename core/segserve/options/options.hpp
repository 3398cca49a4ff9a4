#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"

namespace segserve {

/// The dissimilarity by which regions are merged: the rows of the paper's Table 1, by name.
enum class Method : std::uint8_t {
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

/// Weights of the supervoxel distance (VCCS): without unit, 0 to 100.
struct SupervoxelWeights {
  double color = 0.2;    ///< of the RGB distance over 255
  double spatial = 0.4;  ///< of the Euclidean distance over the seed resolution
  double normal = 1.0;   ///< of 1 - |cos| of the angle between the normals
};

/// What a caller may ask for. Ranges, units and defaults are in `option_table`.
struct Options {
  Method method = Method::kLambdaConvex;
  /// Edge of a voxel: metres in a WORLD view; in a CAMERA view metres at 1 m distance.
  double voxel_resolution = 0.008;
  /// Distance between the seeds of supervoxels, metres.
  double seed_resolution = 0.08;
  SupervoxelWeights weights;
  /// Weight of colour against geometry for `fixed-lambda`.
  double lambda = 0.5;
  /// Cut the merge tree where the weight reaches this, [0, 1]; unset: `default_threshold(method)`.
  std::optional<double> threshold = std::nullopt;
  /// Cut the merge tree at this number of regions instead; excludes `threshold`.
  std::optional<std::uint32_t> regions = std::nullopt;
  /// Threads within one call; the result does not depend on it.
  std::uint32_t threads = 1;
};

/// The threshold the paper learnt for the method (Table 1).
double default_threshold(Method method);

/// One numeric option: its name (the same on the command line, in the API and in messages), what
/// it means, its unit ("" if none), its closed range and its default.
struct OptionInfo {
  std::string_view name;
  std::string_view unit;
  std::string_view description;
  double minimum;
  double maximum;
  std::optional<double> default_value;  ///< unset: depends on the method, or the option is off
};

/// Every numeric option, for `--help`, GetServerInfo and `violations`.
std::span<const OptionInfo> option_table();

struct FieldViolation {
  std::string field;        ///< an option's name
  std::string description;  ///< what is wrong with its value, and what is allowed
};

/// Every fault of the options at once; empty if they are valid.
std::vector<FieldViolation> violations(const Options& options);

/// The same as a status: INVALID_ARGUMENT naming every wrong option, or OK.
absl::Status check(const Options& options);

}  // namespace segserve
