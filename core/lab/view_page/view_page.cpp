// SPDX-License-Identifier: Apache-2.0
#include "core/lab/view_page/view_page.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "core/base/status_macros.hpp"
#include "core/lab/view_page/page_array.hpp"
#include "core/lab/view_page/page_data.hpp"
#include "core/lab/view_page/supervoxel_neighbors.hpp"
#include "fmt/format.h"
#include "nlohmann/json.hpp"

namespace segserve::view_page {
namespace {

using Json = nlohmann::ordered_json;
using Indices = std::vector<std::uint32_t>;

Indices shown_points(const CloudView& cloud) {
  const bool is_camera = cloud.view.kind == ViewKind::kCamera;
  Indices shown;
  for (std::uint32_t i = 0; i < cloud.size(); ++i) {
    const bool is_zero = cloud.x[i] == 0 && cloud.y[i] == 0 && cloud.z[i] == 0;
    if (is_finite(cloud.x[i], cloud.y[i], cloud.z[i]) && !(is_camera && is_zero)) shown.push_back(i);
  }
  return shown;
}

template <typename T>
std::vector<T> pick(std::span<const T> values, const Indices& points) {
  std::vector<T> picked;
  picked.reserve(points.size());
  for (const std::uint32_t i : points) picked.push_back(values[i]);
  return picked;
}

template <typename T>
Json add(PageArrays& arrays, const std::vector<T>& values) {
  return arrays.add(std::span<const T>(values));
}

Json add_colors(PageArrays& arrays, std::span<const std::uint32_t> rgb, const Indices& shown) {
  Json json;
  for (const auto& [name, channel] :
       {std::make_pair("red", red), std::make_pair("green", green), std::make_pair("blue", blue)}) {
    std::vector<std::uint8_t> values;
    values.reserve(shown.size());
    for (const std::uint32_t i : shown) values.push_back(channel(rgb[i]));
    json[name] = add(arrays, values);
  }
  return json;
}

/// The labels that occur, of which the first is 0; and for each shown point the index of its label. Labels beyond the
/// 65,535th count as "not labeled".
struct Truth {
  Indices labels;
  std::vector<std::uint16_t> index;
};

Truth truth_of(std::span<const std::uint32_t> label, const Indices& shown) {
  Truth truth{.labels = pick(label, shown), .index = {}};
  truth.labels.push_back(0);
  std::ranges::sort(truth.labels);
  truth.labels.erase(std::unique(truth.labels.begin(), truth.labels.end()), truth.labels.end());
  for (const std::uint32_t i : shown) {
    const auto at = std::ranges::lower_bound(truth.labels, label[i]) - truth.labels.begin();
    truth.index.push_back(at <= std::numeric_limits<std::uint16_t>::max() ? static_cast<std::uint16_t>(at) : 0);
  }
  return truth;
}

Json vector_json(const auto& v) { return {v.x(), v.y(), v.z()}; }

Json cloud_json(PageArrays& arrays, const PageCloud& cloud, const Indices& shown, double spacing) {
  const CloudView& points = cloud.points;
  const bool is_camera = points.view.kind == ViewKind::kCamera;
  Json json{
      {"view", is_camera ? "camera" : "world"},
      {"sensor", points.view.sensor ? vector_json(*points.view.sensor) : Json()},
      {"spacing", spacing},
      {"placement", {{"scale", vector_json(cloud.placement.scale)}, {"offset", vector_json(cloud.placement.offset)}}}};
  Json& columns = json["arrays"];
  columns["x"] = add(arrays, pick(points.x, shown));
  columns["y"] = add(arrays, pick(points.y, shown));
  columns["z"] = add(arrays, pick(points.z, shown));
  if (points.has_color()) columns.update(add_colors(arrays, points.rgb, shown));
  if (!cloud.truth.empty()) {
    const Truth truth = truth_of(cloud.truth, shown);
    columns["truth"] = add(arrays, truth.index);
    json["truth_labels"] = truth.labels;
  }
  return json;
}

Json normals_json(PageArrays& arrays, const std::vector<Eigen::Vector3d>& normals) {
  std::vector<float> values;
  for (const Eigen::Vector3d& normal : normals) {
    for (const double v : normal.normalized()) values.push_back(static_cast<float>(v));
  }
  return add(arrays, values);
}

Json result_json(PageArrays& arrays, const PageResult& result, const SupervoxelNeighbors& neighbors,
                 const Indices& shown) {
  const Segmentation& segmentation = *result.segmentation;
  const MergeTree& tree = segmentation.tree;
  Indices edges;
  for (const auto& [a, b] : neighbors.pairs) edges.insert(edges.end(), {a, b});
  const auto merged = std::ranges::count(tree.kind, MergeKind::kMerged);
  Json json{{"name", result.name},
            {"method", result.method},
            {"cloud", result.cloud},
            {"threshold", segmentation.threshold.value_or(0)},
            {"regions", result.regions ? Json(*result.regions) : Json()},
            {"merged_rows", merged}};
  json["arrays"] = {{"supervoxel", add(arrays, pick(std::span(segmentation.supervoxels), shown))},
                    {"leaf_points", add(arrays, tree.leaf_points)},
                    {"left", add(arrays, tree.left)},
                    {"right", add(arrays, tree.right)},
                    {"weight", add(arrays, tree.weight)},
                    {"edges", add(arrays, edges)}};
  if (!segmentation.supervoxel_normals.empty()) {
    json["arrays"]["normals"] = normals_json(arrays, segmentation.supervoxel_normals);
  }
  return json;
}

absl::Status check_result(const PageResult& result, std::span<const PageCloud> clouds) {
  const Segmentation& segmentation = *result.segmentation;
  const std::size_t points = clouds[result.cloud].points.size();
  if (segmentation.supervoxels.size() != points) {
    return absl::InvalidArgumentError(fmt::format("{}: it has the supervoxels of {} points, but the cloud has {}",
                                                  result.name, segmentation.supervoxels.size(), points));
  }
  const auto largest = std::ranges::max_element(segmentation.supervoxels);
  if (points > 0 && *largest > segmentation.tree.leaf_count()) {
    return absl::InvalidArgumentError(fmt::format("{}: supervoxel {} is not a leaf of the tree, which has {}",
                                                  result.name, *largest, segmentation.tree.leaf_count()));
  }
  return absl::OkStatus();
}

/// The edge of the voxels, meters, in which neighbors are looked for. Those of a sweep grow with the range, and are
/// taken as wide as in the middle of it, and a half more.
double voxel_of(const Resolution& resolution, const CloudView& cloud) {
  constexpr double kUnknown = 0.01, kWider = 1.5;  // results of older versions do not tell their voxels
  if (resolution.voxel <= 0) return kUnknown;
  if (resolution.reason != ResolutionReason::kSweep || !cloud.view.sensor) return resolution.voxel;
  std::vector<float> ranges;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const float range = (Eigen::Vector3f(cloud.x[i], cloud.y[i], cloud.z[i]) - *cloud.view.sensor).norm();
    if (std::isfinite(range)) ranges.push_back(range);
  }
  if (ranges.empty()) return resolution.voxel;
  const auto middle = ranges.begin() + static_cast<std::ptrdiff_t>(ranges.size() / 2);
  std::ranges::nth_element(ranges, middle);
  return kWider * resolution.voxel * std::max(1.0, static_cast<double>(*middle));
}

}  // namespace

absl::StatusOr<PageData> page_data(const std::string& title, std::span<const PageCloud> clouds,
                                   std::span<const PageResult> results) {
  std::vector<Indices> shown;
  for (const PageCloud& cloud : clouds) shown.push_back(shown_points(cloud.points));

  PageArrays arrays;
  Json json{{"title", title}, {"clouds", Json::array()}, {"results", Json::array()}};
  std::vector<double> spacing(clouds.size(), 0);
  for (const PageResult& result : results) {
    RETURN_IF_ERROR(check_result(result, clouds));
    const double voxel = voxel_of(result.segmentation->resolution, clouds[result.cloud].points);
    const auto neighbors = supervoxel_neighbors(clouds[result.cloud].points, result.segmentation->supervoxels, voxel);
    spacing[result.cloud] = neighbors.spacing;
    json["results"].push_back(result_json(arrays, result, neighbors, shown[result.cloud]));
  }
  for (std::size_t i = 0; i < clouds.size(); ++i) {
    json["clouds"].push_back(cloud_json(arrays, clouds[i], shown[i], spacing[i]));
  }
  return PageData{std::move(json), std::move(arrays).texts()};
}

absl::StatusOr<std::string> make_page(std::string_view bundle, const std::string& title,
                                      std::span<const PageCloud> clouds, std::span<const PageResult> results) {
  ASSIGN_OR_RETURN(const PageData data, page_data(title, clouds, results));
  std::string elements;
  for (const auto& [id, text] : data.arrays) {
    elements += fmt::format(R"(<script type="application/gzip" id="{}">)", id);
    elements += text;
    elements += "</script>\n";
  }
  return put_data(bundle, data.json, elements);
}

}  // namespace segserve::view_page
