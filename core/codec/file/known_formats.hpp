// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace segserve::codec {

/// The formats that decode_cloud reads, for messages.
inline constexpr std::string_view kReadableFormats =
    "PCD, PLY, LAS, NPY, NPZ, OBJ, KITTI, and text such as XYZ, PTS or CSV";

/// Names the format of such a file, as in "this is .."; empty for unknown bytes.
std::string_view format_name(std::string_view file);

/// Names the format of a file that is known and cannot be read, and says what to do with it. nullopt for unknown bytes.
std::optional<std::string> advice_on_format(std::string_view file);

}  // namespace segserve::codec
