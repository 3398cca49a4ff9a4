// SPDX-License-Identifier: Apache-2.0
#include "proto/text/view_text.hpp"

#include "fmt/format.h"
#include "proto/text/number_list.hpp"

namespace segserve::text {

std::optional<View> parse_view(std::string_view text) {
  constexpr std::string_view kPositioned = "world:";
  if (text == "camera") return View::camera();
  if (text == "world") return View::world();
  if (!text.starts_with(kPositioned)) return std::nullopt;
  const auto position = parse_numbers<float, 3>(text.substr(kPositioned.size()));
  if (!position) return std::nullopt;
  return View::world((*position)[0], (*position)[1], (*position)[2]);
}

std::string view_text(const View& view) {
  if (view.kind == ViewKind::kCamera) return "camera";
  if (!view.sensor) return "world";
  return fmt::format("world:{},{},{}", view.sensor->x(), view.sensor->y(), view.sensor->z());
}

}  // namespace segserve::text
