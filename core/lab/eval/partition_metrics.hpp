#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace segserve::eval {

enum class Better : std::uint8_t { kHigher, kLower, kNeither };

/// One number by which a scene is scored: "protocol.score", as in the JSON.
struct Metric {
  std::string_view name;
  Better better = Better::kNeither;
};

/// Every one, in the order of the JSON.
inline constexpr std::array kMetrics = {
    Metric{"supervoxels"},                               // how many
    Metric{"segments"},                                  // how many
    Metric{"ms", Better::kLower},                        // segmentation alone
    Metric{"one_to_one.wov", Better::kHigher},           // scores.hpp, one_to_one_scores
    Metric{"one_to_one.tp", Better::kHigher},            //
    Metric{"one_to_one.fp", Better::kLower},             //
    Metric{"one_to_one.fn", Better::kLower},             //
    Metric{"one_to_one.f", Better::kHigher},             //
    Metric{"paper_all.wov", Better::kHigher},            // paper_scores of all regions
    Metric{"paper_all.tp", Better::kHigher},             //
    Metric{"paper_all.fp", Better::kLower},              //
    Metric{"paper_all.fn", Better::kLower},              //
    Metric{"paper_objects.wov", Better::kHigher},        // paper_scores of the objects
    Metric{"paper_objects.tp", Better::kHigher},         //
    Metric{"paper_objects.fp", Better::kLower},          //
    Metric{"paper_objects.fn", Better::kLower},          //
    Metric{"variation_of_information", Better::kLower},  // bits
    Metric{"supervoxel_quality.achievable_accuracy", Better::kHigher},
    Metric{"supervoxel_quality.undersegmentation_error", Better::kLower},
    Metric{"supervoxel_quality.boundary_recall", Better::kHigher},  // boundary.hpp
};

/// The index of a metric; a name that does not exist does not compile.
consteval std::size_t metric(std::string_view name) {
  std::size_t i = 0;
  while (kMetrics[i].name != name) ++i;
  return i;
}

/// A value of each metric; nothing where it is undefined: objects of a scene without any, boundaries of a cloud that is
/// no image.
using MetricValues = std::array<std::optional<double>, kMetrics.size()>;

struct SceneScores {
  std::string file;  ///< the name within its folder
  MetricValues values;
};

/// Of each metric, the mean over the scenes that have it.
MetricValues mean(std::span<const SceneScores> scenes);

}  // namespace segserve::eval
