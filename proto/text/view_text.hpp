// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "segserve/cloud.hpp"

namespace segserve::text {

/// Reads "camera", "world" or "world:X,Y,Z", where X, Y, Z is the sensor's position in the frame of the cloud, in
/// meters. Nothing for any other text.
std::optional<View> parse_view(std::string_view text);

/// The rule that parse_view states when it refuses a text.
inline constexpr std::string_view kViewRule = "camera, world or world:X,Y,Z with the sensor's position in meters";

/// The text that parse_view reads as this view.
std::string view_text(const View& view);

}  // namespace segserve::text
