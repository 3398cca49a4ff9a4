#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"

namespace segserve::segctl {

/// "camera", "world" or "world:X,Y,Z" (the sensor's position, metres). INVALID_ARGUMENT otherwise.
absl::StatusOr<View> parse_view(std::string_view text);

/// The same text back.
std::string view_text(const View& view);

}  // namespace segserve::segctl
