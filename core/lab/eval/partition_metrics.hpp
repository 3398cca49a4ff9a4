// SPDX-License-Identifier: Apache-2.0
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

/// A number by which a scene is scored. Its name is "protocol.score", as in the JSON.
struct Metric {
  std::string_view name;
  Better better = Better::kNeither;
};

/// All metrics, in the order of the JSON.
inline constexpr std::array kMetrics = {
    Metric{"supervoxels"},                                    // their number
    Metric{"segments"},                                       // their number
    Metric{"ms", Better::kLower},                             // the segmentation alone
    Metric{"one_to_one.wov", Better::kHigher},                // scores.hpp, one_to_one_scores
    Metric{"one_to_one.tp", Better::kHigher},                 //
    Metric{"one_to_one.fp", Better::kLower},                  //
    Metric{"one_to_one.fn", Better::kLower},                  //
    Metric{"one_to_one.f", Better::kHigher},                  //
    Metric{"paper_all.wov", Better::kHigher},                 // paper_scores of all regions
    Metric{"paper_all.tp", Better::kHigher},                  //
    Metric{"paper_all.fp", Better::kLower},                   //
    Metric{"paper_all.fn", Better::kLower},                   //
    Metric{"paper_objects.wov", Better::kHigher},             // paper_scores of the objects
    Metric{"paper_objects.tp", Better::kHigher},              //
    Metric{"paper_objects.fp", Better::kLower},               //
    Metric{"paper_objects.fn", Better::kLower},               //
    Metric{"instance.ap", Better::kHigher},                   // instance_scores.hpp, instance_scores
    Metric{"instance.ap50", Better::kHigher},                 //
    Metric{"instance.ap75", Better::kHigher},                 //
    Metric{"instance.ar", Better::kHigher},                   //
    Metric{"instance.ar50", Better::kHigher},                 //
    Metric{"instance.ar75", Better::kHigher},                 //
    Metric{"panoptic_all.pq", Better::kHigher},               // panoptic_scores of all regions
    Metric{"panoptic_all.sq", Better::kHigher},               //
    Metric{"panoptic_all.rq", Better::kHigher},               //
    Metric{"panoptic_objects.pq", Better::kHigher},           // panoptic_scores of the objects
    Metric{"panoptic_objects.sq", Better::kHigher},           //
    Metric{"panoptic_objects.rq", Better::kHigher},           //
    Metric{"overlap_objects.precision", Better::kHigher},     // overlap_scores.hpp
    Metric{"overlap_objects.recall", Better::kHigher},        //
    Metric{"overlap_objects.f", Better::kHigher},             //
    Metric{"overlap_objects.objects_f75", Better::kHigher},   // share of the objects
    Metric{"object_counts.objects"},                          // instance_scores.hpp, count_objects
    Metric{"object_counts.over_segmented", Better::kLower},   //
    Metric{"object_counts.under_segmented", Better::kLower},  //
    Metric{"object_counts.missed", Better::kLower},           //
    Metric{"boundary.precision", Better::kHigher},            // boundary_scores.hpp, of the segments
    Metric{"boundary.recall", Better::kHigher},               //
    Metric{"boundary.f", Better::kHigher},                    //
    Metric{"variation_of_information", Better::kLower},       // bits
    Metric{"supervoxel_quality.achievable_accuracy", Better::kHigher},
    Metric{"supervoxel_quality.undersegmentation_error", Better::kLower},
    Metric{"supervoxel_quality.boundary_recall", Better::kHigher},  // boundary_scores.hpp
};

/// The index of a metric; a name that does not exist does not compile.
consteval std::size_t metric(std::string_view name) {
  std::size_t i = 0;
  while (kMetrics[i].name != name) ++i;
  return i;
}

/// The value of each metric. It is unset where it is undefined: scores of objects in a scene without objects,
/// boundaries of a cloud that is not an image, and means or shares of nothing (the precision of no detection).
using MetricValues = std::array<std::optional<double>, kMetrics.size()>;

struct SceneScores {
  std::string file;  ///< Its name within the folder.
  MetricValues values;
};

/// The mean of each metric over the scenes in which it is defined.
MetricValues mean(std::span<const SceneScores> scenes);

}  // namespace segserve::eval
