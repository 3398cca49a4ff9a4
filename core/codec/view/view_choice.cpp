// SPDX-License-Identifier: Apache-2.0
#include "core/codec/view/view_choice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/codec/common/text_parsing.hpp"
#include "core/codec/view/hidden_points.hpp"
#include "core/codec/view/sensor_geometry.hpp"

namespace segserve::codec {
namespace {

constexpr std::string_view kStatement = "segserve view ";

std::string shape_text(const CloudView& cloud) { return fmt::format("{} x {}", cloud.width, cloud.height); }

ViewChoice camera(bool is_behind, std::string reason) {
  ViewChoice choice{.kind = ViewKind::kCamera, .y_and_z_are_reversed = is_behind};
  choice.rule = "CAMERA" + std::move(reason);
  if (is_behind) choice.rule += "; y points up and z backward in the file";
  return choice;
}

ViewChoice sweep(std::string_view lines) {
  return {
      .sensor = Eigen::Vector3d::Zero(),
      .rule = fmt::format("WORLD with the sensor at the origin, because the points lie on {} of constant elevation, "
                          "as those of a spinning LiDAR",
                          lines)};
}

ViewChoice world(const Eigen::Vector3d& position, std::string reason) {
  return {.sensor = position,
          .rule = fmt::format("WORLD with the sensor at ({}, {}, {}), {}", position.x(), position.y(), position.z(),
                              std::move(reason))};
}

ViewChoice no_sensor(std::string_view reason) {
  return {.rule = fmt::format("WORLD without a sensor, because {}", reason)};
}

/// A view that somebody names.
ViewChoice named(const CloudView& cloud, const View& view, std::string_view by, StopCheck& check) {
  if (view.kind == ViewKind::kCamera) return camera(is_behind_origin(cloud, check), fmt::format(", as {}", by));
  ViewChoice choice{.rule = fmt::format("WORLD, as {}", by)};
  if (view.sensor) choice.sensor = view.sensor->cast<double>();
  choice.cameras = view.cameras;
  return choice;
}

bool is_inside(const Extent& e) {
  bool inside = true;
  for (int axis = 0; axis < 3; ++axis) inside = inside && e.low[axis] <= 0 && e.high[axis] >= 0;
  return inside;
}

/// Whether the origin is so far from the points that no sensor there has seen them.
bool is_far_away(const Extent& e) {
  constexpr float kDiagonals = 10;
  float distance = 0, diagonal = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const float outside = std::max({e.low[axis], -e.high[axis], 0.0F});
    distance += outside * outside;
    diagonal += (e.high[axis] - e.low[axis]) * (e.high[axis] - e.low[axis]);
  }
  return distance > kDiagonals * kDiagonals * diagonal;
}

/// Whether the origin is below the points, so that it cannot be the sensor that saw them: they lie on a horizontal
/// plane, or reach farther aside than a camera sees that looks up. Beside the points, only both together tell.
bool is_below(const CloudView& cloud, const Extent& e, StopCheck& check) {
  bool is_beside = false;
  for (int axis = 0; axis < 2; ++axis) is_beside = is_beside || e.low[axis] > 0 || e.high[axis] < 0;
  // The noise of a floor at the height of the origin does not make the floor one that is seen.
  const float noise = is_beside ? (e.high[2] - e.low[2]) / 50 : 0;
  if (e.low[2] < -noise) return false;
  if (is_beside) return !e.is_in_frustum() && has_horizontal_plane(cloud, e, check);
  return !e.is_in_frustum() || has_horizontal_plane(cloud, e, check);
}

/// Chooses by the position that an entry of the file has, or by the lack of one.
ViewChoice by_entry(const CloudView& cloud, const ViewEvidence& evidence, const Extent& extent, StopCheck& check) {
  if (evidence.has_position()) return world(*evidence.position, fmt::format("its {}", evidence.entry));
  if (!evidence.has_entry) return no_sensor("the file does not tell where it is");
  if (cloud.height > 1) {
    return no_sensor(
        fmt::format("its {} is the default, and a sensor there has not seen the points of the organized "
                    "cloud ({}) row by row",
                    evidence.entry, shape_text(cloud)));
  }
  if (is_far_away(extent)) return no_sensor(fmt::format("its {} is the default, far from the points", evidence.entry));
  if (is_inside(extent)) return no_sensor(fmt::format("its {} is the default, inside the points", evidence.entry));
  if (is_below(cloud, extent, check)) {
    return no_sensor(fmt::format("its {} is the default, below the points", evidence.entry));
  }
  if (hide_one_another(cloud, check) || lie_in_layers(cloud, check)) {
    return no_sensor(fmt::format("its {} is the default, from where the points hide one another", evidence.entry));
  }
  return world(Eigen::Vector3d::Zero(), fmt::format("its {}, from where it can have seen the points", evidence.entry));
}

ViewChoice by_rows(const CloudView& cloud, const ViewEvidence& evidence, const Extent& extent, StopCheck& check) {
  const bool is_one_sided = extent.is_in_front() || extent.is_behind();
  const Agreement pixels = is_one_sided ? follows_pixels(cloud, check) : Agreement::kNo;
  if (pixels == Agreement::kYes || (pixels == Agreement::kUnknown && !evidence.has_position())) {
    return camera(
        extent.is_behind(),
        fmt::format(": the cloud is organized ({}), with all points in front of the origin", shape_text(cloud)));
  }
  if (follows_rings(cloud, check)) return sweep("rows or columns");
  return by_entry(cloud, evidence, extent, check);
}

ViewChoice by_values(const CloudView& cloud, const ViewEvidence& evidence, const Extent& extent, StopCheck& check) {
  const bool is_one_sided = extent.is_in_front() || extent.is_behind();
  if (is_one_sided && has_pixel_values(cloud, extent, check)) {
    return camera(extent.is_behind(), ": the points lie on the rays of a camera's pixels");
  }
  if (!evidence.has_position() && !is_far_away(extent) && has_ring_values(cloud, check)) return sweep("rings");
  return by_entry(cloud, evidence, extent, check);
}

ViewChoice choose(const CloudView& cloud, const ViewEvidence& evidence, StopCheck& check) {
  if (evidence.given) return named(cloud, *evidence.given, "asked for", check);
  if (evidence.stated) return named(cloud, *evidence.stated, "the file says", check);
  const Extent extent = extent_of(cloud, check);
  if (extent.points == 0 && extent.zeros > 0 && cloud.height > 1) {
    return camera(false, ": the cloud is organized, and no pixel has a depth");
  }
  if (extent.points == 0) return no_sensor("there are no points to judge by");
  return cloud.height > 1 ? by_rows(cloud, evidence, extent, check) : by_values(cloud, evidence, extent, check);
}

}  // namespace

absl::StatusOr<ViewChoice> choose_view(const CloudView& cloud, const ViewEvidence& evidence, StopCheck& check) {
  ViewChoice choice = choose(cloud, evidence, check);
  if (check.stopped()) return check.status();
  return choice;
}

std::string view_statement(const View& view) {
  std::string text(kStatement);
  if (view.kind == ViewKind::kCamera) return text += "camera";
  text += "world";
  if (view.sensor) text += fmt::format(" {} {} {}", view.sensor->x(), view.sensor->y(), view.sensor->z());
  return text;
}

std::optional<View> stated_view(std::string_view comment) {
  if (!comment.starts_with(kStatement)) return std::nullopt;
  const auto words = split_words(comment.substr(kStatement.size()));
  if (words.size() == 1 && words[0] == "camera") return View::camera();
  if (words.empty() || words[0] != "world") return std::nullopt;
  if (words.size() == 1) return View::world();
  std::array<float, 3> p{};
  if (words.size() != 4) return std::nullopt;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!parse_scalar(words[i + 1], ScalarType::kFloat32, reinterpret_cast<std::byte*>(&p[i]))) return std::nullopt;
  }
  if (!is_finite(p[0], p[1], p[2])) return std::nullopt;
  return View::world(p[0], p[1], p[2]);
}

}  // namespace segserve::codec
