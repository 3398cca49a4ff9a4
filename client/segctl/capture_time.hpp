// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

namespace segserve::segctl {

/// The time of capture in the name of a file, seconds: "1305031102.175304.pcd" or "cloud_1305031102175304.pcd". What
/// follows the letters and signs at the front must be seconds with at least three digits after the point, or a whole
/// number of 13, 16 or 19 digits, which are milliseconds, microseconds or nanoseconds since 1970. nullopt for other
/// names, such as those with the number of a frame.
std::optional<double> capture_time(std::string_view file_name);

}  // namespace segserve::segctl
