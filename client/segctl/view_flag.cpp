#include "client/segctl/view_flag.hpp"

#include <charconv>
#include <cmath>
#include <optional>

#include "fmt/format.h"

namespace segserve::segctl {
namespace {

std::optional<Eigen::Vector3f> parse_position(std::string_view text) {
  Eigen::Vector3f position;
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  for (Eigen::Index axis = 0; axis < position.size(); ++axis) {
    if (axis > 0 && (at == end || *at++ != ',')) return std::nullopt;
    const auto [rest, error] = std::from_chars(at, end, position[axis]);
    if (error != std::errc{} || !std::isfinite(position[axis])) return std::nullopt;
    at = rest;
  }
  return at == end ? std::optional(position) : std::nullopt;
}

}  // namespace

absl::StatusOr<View> parse_view(std::string_view text) {
  constexpr std::string_view kPositioned = "world:";
  if (text == "camera") return View::camera();
  if (text == "world") return View::world();
  if (text.starts_with(kPositioned)) {
    if (const auto position = parse_position(text.substr(kPositioned.size()))) {
      return View{ViewKind::kWorld, position};
    }
  }
  return absl::InvalidArgumentError(
      fmt::format("--view {}: must be camera, world or world:X,Y,Z with the sensor's position in metres", text));
}

std::string view_text(const View& view) {
  if (view.kind == ViewKind::kCamera) return "camera";
  if (!view.sensor) return "world";
  return fmt::format("world:{},{},{}", view.sensor->x(), view.sensor->y(), view.sensor->z());
}

}  // namespace segserve::segctl
