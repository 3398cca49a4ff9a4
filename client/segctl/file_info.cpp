// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/file_info.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "client/segctl/input_file.hpp"
#include "client/segctl/summary.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "fmt/format.h"
#include "proto/text/result_json.hpp"
#include "proto/text/view_text.hpp"
#include "segserve/client/topic_reader.hpp"
#include "segserve/codec/cloud_file.hpp"
#include "segserve/codec/point_spacing.hpp"
#include "segserve/codec/unit_conversion.hpp"

namespace segserve::segctl {
namespace {

using Json = nlohmann::ordered_json;

struct Box {
  Eigen::Vector3d low, high;
  std::size_t finite = 0;
};

/// The box of the finite points, in the file's coordinates.
Box box_of(const codec::LabeledCloud& scene) {
  Box box;
  const Cloud& cloud = scene.cloud;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!is_finite(cloud.x[i], cloud.y[i], cloud.z[i])) continue;
    const Eigen::Vector3d p = scene.placement.to_file({cloud.x[i], cloud.y[i], cloud.z[i]});
    box.low = box.finite == 0 ? p : box.low.cwiseMin(p).eval();
    box.high = box.finite == 0 ? p : box.high.cwiseMax(p).eval();
    ++box.finite;
  }
  return box;
}

/// The number of cubes of this edge, meters, that hold points.
std::size_t count_cubes(const Cloud& cloud, double edge) {
  std::vector<std::array<double, 3>> cubes;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!is_finite(cloud.x[i], cloud.y[i], cloud.z[i])) continue;
    cubes.push_back({std::floor(cloud.x[i] / edge), std::floor(cloud.y[i] / edge), std::floor(cloud.z[i] / edge)});
  }
  std::ranges::sort(cubes);
  return static_cast<std::size_t>(std::ranges::unique(cubes).begin() - cubes.begin());
}

/// The spacing times a power of the square root of two at which a voxel holds four points on average; nullopt in a
/// camera's frame, where voxels grow with the distance, and for points farther apart than the largest voxels.
std::optional<double> fitting_resolution(const Cloud& cloud, double spacing) {
  constexpr double kLargest = 1, kWanted = 4;
  if (cloud.view.kind == ViewKind::kCamera) return std::nullopt;
  for (double edge = spacing; edge <= kLargest; edge *= std::sqrt(2.0)) {
    if (kWanted * static_cast<double>(count_cubes(cloud, edge)) <= static_cast<double>(cloud.size())) return edge;
  }
  return std::nullopt;
}

Json attributes_json(const codec::LabeledCloud& scene) {
  Json list = Json::array();
  for (const codec::Attribute& attribute : scene.attributes) {
    list.push_back({{"name", attribute.name}, {"type", name(attribute.type)}, {"count", attribute.count}});
  }
  return list;
}

/// The unit that the coordinates are taken in, and the one that their spacing makes plain.
Json unit_json(const codec::LabeledCloud& scene) {
  Json json{{"taken", Json()}, {"guess", Json()}, {"why", Json()}};
  if (const auto unit = codec::length_unit_of(scene.placement.meters_per_unit())) json["taken"] = name(*unit);
  Cloud in_file_unit = scene.cloud;
  for (std::vector<float>* axis : {&in_file_unit.x, &in_file_unit.y, &in_file_unit.z}) {
    for (float& v : *axis) v = static_cast<float>(v / scene.placement.meters_per_unit());
  }
  const auto guessed = codec::to_meters(in_file_unit, {.view = View::world(), .unit = codec::LengthUnit::kAuto});
  if (!guessed.ok() || guessed->warnings.empty()) return json;
  json["guess"] = guessed->placement.meters_per_unit() == 1 ? "m" : "mm";
  json["why"] = guessed->warnings.front().message;
  return json;
}

std::string words(const Json& list) {
  std::string text;
  for (const Json& entry : list) {
    text += fmt::format("{}{} ({}{})", text.empty() ? "" : ", ", entry["name"].get<std::string>(),
                        entry["type"].get<std::string>(),
                        entry["count"] == 1 ? "" : fmt::format(" x {}", entry["count"].get<std::size_t>()));
  }
  return text.empty() ? "none" : text;
}

std::string position_text(const Json& v) {
  return fmt::format("({:.10g}, {:.10g}, {:.10g})", v[0].get<double>(), v[1].get<double>(), v[2].get<double>());
}

}  // namespace

absl::StatusOr<Json> file_info(const std::string& path, codec::ReadOptions options) {
  options.keep_everything = true;
  ASSIGN_OR_RETURN(const std::string bytes, read_input(path));
  auto scene = codec::decode_cloud(std::as_bytes(std::span(bytes)), {}, options);
  if (!scene.ok()) return with_prefix(input_name(path), scene.status());
  const Box box = box_of(*scene);
  const auto spacing = codec::point_spacing(scene->cloud);
  const std::set<std::uint32_t> labels(scene->label.begin(), scene->label.end());

  Json json;
  json["file"] = input_name(path);
  json["format"] = scene->format;
  json["bytes"] = bytes.size();
  json["points"] = scene->cloud.size();
  json["width"] = scene->cloud.width;
  json["height"] = scene->cloud.height;
  json["finite"] = box.finite;
  json["color"] = scene->cloud.has_color();
  json["labels"] = scene->label.empty() ? Json() : Json(labels.size());
  json["attributes"] = attributes_json(*scene);
  json["box"] =
      box.finite == 0 ? Json() : Json{{"low", text::vector_json(box.low)}, {"high", text::vector_json(box.high)}};
  json["spacing"] = spacing ? Json(*spacing / scene->placement.meters_per_unit()) : Json();
  json["unit"] = unit_json(*scene);
  json["view"] = text::view_text(to_file(scene->placement, scene->cloud.view));
  json["view_rule"] = scene->view_rule;
  json["placement"] = {{"scale", text::vector_json(scene->placement.scale)},
                       {"offset", text::vector_json(scene->placement.offset)}};
  const auto resolution = spacing ? fitting_resolution(scene->cloud, *spacing) : std::nullopt;
  json["voxel_resolution"] = resolution ? Json(*resolution) : Json();
  json["warnings"] = warnings_json(scene->warnings);
  return json;
}

absl::StatusOr<Json> recording_info(const std::string& path) {
  ASSIGN_OR_RETURN(const auto topics, client::list_topics(path));
  Json json{{"file", path}, {"format", "recording"}, {"topics", Json::array()}};
  for (const client::TopicInfo& topic : topics) {
    json["topics"].push_back({{"name", topic.name},
                              {"type", topic.type},
                              {"encoding", topic.encoding},
                              {"messages", topic.messages},
                              {"has_frames", topic.has_frames}});
  }
  return json;
}

std::string recording_info_text(const Json& info) {
  std::string text =
      fmt::format("{}: a recording of {} topics\n", info["file"].get<std::string>(), info["topics"].size());
  for (const Json& topic : info["topics"]) {
    text += fmt::format("  {:<30} {:>7} x {}{}\n", topic["name"].get<std::string>(),
                        topic["messages"].get<std::uint64_t>(), topic["type"].get<std::string>(),
                        topic["has_frames"].get<bool>() ? "; segctl segment --topic reads it" : "");
  }
  return text;
}

std::string file_info_text(const Json& info) {
  const auto height = info["height"].get<std::uint32_t>();
  std::string text = fmt::format(
      "{}: {}, {} points{}, {} finite\n", info["file"].get<std::string>(), info["format"].get<std::string>(),
      info["points"].get<std::size_t>(),
      height > 1 ? fmt::format(" ({} x {})", info["width"].get<std::uint32_t>(), height) : ", not organized",
      info["finite"].get<std::size_t>());
  const Json& labels = info["labels"];
  text += fmt::format("colors: {}; labels: {}; other values: {}\n", info["color"].get<bool>() ? "yes" : "no",
                      labels.is_null() ? "none" : fmt::format("{} different", labels.get<std::size_t>()),
                      words(info["attributes"]));
  if (!info["box"].is_null()) {
    text += fmt::format("from {} to {}\n", position_text(info["box"]["low"]), position_text(info["box"]["high"]));
  }
  if (!info["spacing"].is_null()) {
    const Json& resolution = info["voxel_resolution"];
    text += fmt::format("neighboring points are {:.4g} units apart{}\n", info["spacing"].get<double>(),
                        resolution.is_null()
                            ? ""
                            : fmt::format("; a voxel of {:.3g} m would hold four or more", resolution.get<double>()));
  }
  const Json& unit = info["unit"];
  text += fmt::format("unit: {}", unit["taken"].get<std::string>());
  if (!unit["guess"].is_null() && unit["guess"] != unit["taken"]) {
    text +=
        fmt::format("; --unit auto would say {}: {}", unit["guess"].get<std::string>(), unit["why"].get<std::string>());
  }
  text += fmt::format("\nview: {}\n", info["view_rule"].get<std::string>());
  const Eigen::Vector3d offset(info["placement"]["offset"][0], info["placement"]["offset"][1],
                               info["placement"]["offset"][2]);
  if (offset != Eigen::Vector3d::Zero()) {
    text += fmt::format("the cloud is far from the origin, and moved by {} for the segmentation\n",
                        position_text(text::vector_json(-offset)));
  }
  for (const Json& warning : info["warnings"]) {
    text += fmt::format("warning: {}\n", warning["message"].get<std::string>());
  }
  return text;
}

}  // namespace segserve::segctl
