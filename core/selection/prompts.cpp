// SPDX-License-Identifier: Apache-2.0
#include "segserve/prompts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
#include "fmt/format.h"
#include "fmt/ranges.h"

namespace segserve {
namespace {

using Supervoxels = std::span<const std::uint32_t>;

/// A position, and the nearest segmented point so far.
struct Search {
  Eigen::Vector3d position;
  std::size_t point = 0;
  double least = std::numeric_limits<double>::infinity();  // squared distance
};

/// The places of one kind on their way to points.
struct Finder {
  const CloudView& cloud;
  const Supervoxels supervoxels;
  std::vector<std::string>& faults;

  /// The searches of the positions among the places, in their order.
  static std::vector<Search> searches_of(const std::vector<Prompt>& prompts) {
    std::vector<Search> searches;
    for (const Prompt& prompt : prompts) {
      if (const auto* position = std::get_if<Eigen::Vector3d>(&prompt)) searches.push_back({*position});
    }
    return searches;
  }

  PromptedPoint at(const Pixel& pixel) const {
    const auto [column, row] = pixel;
    if (cloud.height <= 1) {
      faults.push_back(fmt::format("pixel {},{}: the cloud is no image; tell a position X,Y,Z", column, row));
      return {};
    }
    if (column >= cloud.width || row >= cloud.height) {
      faults.push_back(
          fmt::format("pixel {},{} is outside the image of {} x {} pixels", column, row, cloud.width, cloud.height));
      return {};
    }
    const std::size_t point = std::size_t{row} * cloud.width + column;
    if (supervoxels[point] == 0) faults.push_back(fmt::format("pixel {},{} has no segmented point", column, row));
    return {point, supervoxels[point], 0};
  }

  std::vector<PromptedPoint> points_of(const std::vector<Prompt>& prompts, std::span<const Search> searches) const {
    std::vector<PromptedPoint> points;
    std::size_t used = 0;
    for (const Prompt& prompt : prompts) {
      if (const auto* pixel = std::get_if<Pixel>(&prompt)) {
        points.push_back(at(*pixel));
      } else {
        const Search& search = searches[used++];
        if (!std::isfinite(search.least)) {
          const Eigen::Vector3d& p = search.position;
          faults.push_back(fmt::format("position {:g},{:g},{:g} is too far away", p.x(), p.y(), p.z()));
        }
        points.push_back({search.point, supervoxels[search.point], std::sqrt(search.least)});
      }
    }
    return points;
  }
};

absl::Status find_nearest(const CloudView& cloud, Supervoxels supervoxels, std::vector<Search>& searches,
                          const StopToken& stop) {
  StopCheck check(stop);
  check.for_each(0, cloud.size(), [&](std::size_t i) {
    if (supervoxels[i] == 0) return std::size_t{1};
    const Eigen::Vector3d point(cloud.x[i], cloud.y[i], cloud.z[i]);
    for (Search& search : searches) {
      const double distance = (point - search.position).squaredNorm();
      if (!(distance < search.least)) continue;
      search.least = distance;
      search.point = i;
    }
    return searches.size();
  });
  return check.status();
}

std::vector<std::uint32_t> leaves_of(const std::vector<PromptedPoint>& points) {
  std::vector<std::uint32_t> leaves;
  for (const PromptedPoint& point : points) leaves.push_back(point.supervoxel - 1);
  return leaves;
}

std::size_t candidate_of(const Segmentation& segmentation, std::optional<std::uint32_t> regions,
                         const Selection& selection, std::int32_t larger) {
  const std::size_t usual =
      regions ? candidate_for_regions(segmentation.tree, selection, *regions)
              : candidate_at_threshold(segmentation.tree, selection, segmentation.threshold.value_or(0));
  const auto wanted = static_cast<std::int64_t>(usual) + larger;
  return static_cast<std::size_t>(
      std::clamp<std::int64_t>(wanted, 0, static_cast<std::int64_t>(selection.candidates()) - 1));
}

void check_places(const char* field, const std::vector<Prompt>& prompts, std::vector<FieldViolation>& faults) {
  if (prompts.size() > kMostPrompts) {
    faults.push_back({field, fmt::format("has {} places, but may have at most {}", prompts.size(), kMostPrompts)});
    return;
  }
  for (std::size_t k = 0; k < prompts.size(); ++k) {
    const auto* position = std::get_if<Eigen::Vector3d>(&prompts[k]);
    if (position != nullptr && !position->allFinite()) {
      faults.push_back({fmt::format("{}[{}]", field, k), "is a position that is not finite"});
    }
  }
}

}  // namespace

std::vector<FieldViolation> violations(const Prompts& prompts) {
  std::vector<FieldViolation> faults;
  if (prompts.include.empty()) faults.push_back({"include", "is empty, so that nothing can be selected"});
  check_places("include", prompts.include, faults);
  check_places("exclude", prompts.exclude, faults);
  return faults;
}

absl::StatusOr<PromptedSelection> select_by_prompts(const CloudView& cloud, const Segmentation& segmentation,
                                                    std::optional<std::uint32_t> regions, const Prompts& prompts,
                                                    const StopToken& stop) {
  const Supervoxels supervoxels = segmentation.supervoxels;
  if (segmentation.tree.leaf_count() == 0) return absl::InvalidArgumentError("the cloud has no segmented point");
  std::vector<Search> searches = Finder::searches_of(prompts.include);
  const std::size_t included = searches.size();
  for (const Search& search : Finder::searches_of(prompts.exclude)) searches.push_back(search);
  if (!searches.empty()) RETURN_IF_ERROR(find_nearest(cloud, supervoxels, searches, stop));

  std::vector<std::string> faults;
  const Finder finder{cloud, supervoxels, faults};
  PromptedSelection selected;
  selected.include = finder.points_of(prompts.include, std::span(searches).first(included));
  selected.exclude = finder.points_of(prompts.exclude, std::span(searches).subspan(included));
  if (!faults.empty()) return absl::InvalidArgumentError(fmt::format("{}", fmt::join(faults, "; ")));
  ASSIGN_OR_RETURN(selected.selection,
                   select(segmentation.tree, leaves_of(selected.include), leaves_of(selected.exclude)));
  selected.candidate = candidate_of(segmentation, regions, selected.selection, prompts.larger);
  selected.thresholds = thresholds_of(segmentation.tree, selected.selection, selected.candidate);

  const std::vector<bool> is_selected =
      leaves_below(segmentation.tree, nodes_of(selected.selection, selected.candidate));
  selected.labels.resize(supervoxels.size());
  StopCheck check(stop);
  check.for_each(0, supervoxels.size(), [&](std::size_t i) {
    selected.labels[i] = supervoxels[i] > 0 && is_selected[supervoxels[i] - 1] ? 1 : 0;
  });
  RETURN_IF_ERROR(check.status());
  return selected;
}

absl::Status describe(const CloudView& cloud, unsigned threads, const StopToken& stop, PromptedSelection& selected) {
  ASSIGN_OR_RETURN(auto statistics, describe_segments(cloud, selected.labels, 1, threads, stop));
  selected.statistics = statistics.front();
  selected.statistics->thresholds = selected.thresholds;
  return absl::OkStatus();
}

}  // namespace segserve
