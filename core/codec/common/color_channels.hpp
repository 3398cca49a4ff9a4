// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/stop_check.hpp"
#include "core/codec/common/column.hpp"
#include "core/codec/common/field_roles.hpp"
#include "segserve/cloud.hpp"
#include "segserve/codec/warning.hpp"

namespace segserve::codec {

/// Red, green and blue.
using Channels = std::array<Column, 3>;

/// How the channels show that a point has no color: by NaN in all three, or by -1, where negative values mean nothing
/// else.
struct MissingColorSigns {
  bool is_nan = false, is_minus_one = false;
};

/// Makes colors of the channels: of bytes, of 16 bits, of floats up to 1, from -1 to 1 or up to 255, as their values
/// tell, or of spherical harmonics. `out` must be 0 before. `claimed` is the type that the channels have by what the
/// file says, if it is the same for all; as text, their numbers have another type. Warns of values that are clamped, or
/// nearly black by their range. Returns how colors that are missing may be marked.
MissingColorSigns read_channels(const Channels& channels, ChannelKind kind, std::optional<ScalarType> claimed,
                                StopCheck& check, std::vector<std::uint32_t>& out, std::vector<Warning>& warnings);

/// Warns of points of a cloud that are there, and have no color by these signs.
void warn_of_missing_channels(const Channels& channels, MissingColorSigns signs, const Cloud& cloud, StopCheck& check,
                              std::vector<Warning>& warnings);

/// Says that so many colors are missing, if any are.
void warn_of_missing_colors(std::size_t missing, std::size_t points, const char* sign, std::vector<Warning>& warnings);

}  // namespace segserve::codec
