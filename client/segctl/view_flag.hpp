// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"

namespace segserve::segctl {

/// Reads "camera", "world" or "world:X,Y,Z", where X, Y, Z is the sensor's position in the frame of the cloud, in
/// meters. INVALID_ARGUMENT for any other text.
absl::StatusOr<View> parse_view(std::string_view text);

}  // namespace segserve::segctl
