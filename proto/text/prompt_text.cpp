// SPDX-License-Identifier: Apache-2.0
#include "proto/text/prompt_text.hpp"

#include <cstdint>

#include "fmt/format.h"
#include "proto/text/number_list.hpp"

namespace segserve::text {

absl::StatusOr<Prompt> parse_prompt(std::string_view text) {
  if (const auto position = parse_numbers<double, 3>(text)) return Prompt(Eigen::Vector3d(position->data()));
  if (const auto pixel = parse_numbers<std::uint32_t, 2>(text)) return Prompt(Pixel{(*pixel)[0], (*pixel)[1]});
  return absl::InvalidArgumentError(fmt::format("'{}' is neither a position X,Y,Z nor a pixel U,V", text));
}

std::string prompt_text(const Prompt& prompt) {
  if (const auto* pixel = std::get_if<Pixel>(&prompt)) return fmt::format("{},{}", pixel->column, pixel->row);
  const auto& position = std::get<Eigen::Vector3d>(prompt);
  return fmt::format("{},{},{}", position.x(), position.y(), position.z());
}

}  // namespace segserve::text
