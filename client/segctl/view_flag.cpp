// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/view_flag.hpp"

#include "client/segctl/number_list.hpp"
#include "fmt/format.h"

namespace segserve::segctl {

absl::StatusOr<View> parse_view(std::string_view text) {
  constexpr std::string_view kPositioned = "world:";
  if (text == "camera") return View::camera();
  if (text == "world") return View::world();
  if (text.starts_with(kPositioned)) {
    if (const auto position = parse_numbers<float, 3>(text.substr(kPositioned.size()))) {
      return View::world((*position)[0], (*position)[1], (*position)[2]);
    }
  }
  return absl::InvalidArgumentError(
      fmt::format("--view {}: must be camera, world or world:X,Y,Z with the sensor's position in meters", text));
}

std::string view_text(const View& view) {
  if (view.kind == ViewKind::kCamera) return "camera";
  if (!view.sensor) return "world";
  return fmt::format("world:{},{},{}", view.sensor->x(), view.sensor->y(), view.sensor->z());
}

}  // namespace segserve::segctl
