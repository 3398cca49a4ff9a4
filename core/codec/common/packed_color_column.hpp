// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/stop_check.hpp"
#include "core/codec/common/column.hpp"
#include "segserve/cloud.hpp"

// Colors that are packed into one number, 0xAARRGGBB.
namespace segserve::codec {

/// The result of read_packed_color, beside the colors.
struct PackedColors {
  bool are_colors = true;  ///< false if a number is no color; what was read means nothing then
  bool some_are_missing = false;
};

/// Reads a packed color for each element of `out`. The low 32 bits of an integer of 4 bytes, and all of a float, are
/// the color; floats all of which are whole numbers of 24 bits are the colors themselves, as some programs convert
/// them. Numbers of 8 bytes, such as those of text, have the value that the 4 bytes of such an integer or float would
/// have: whole numbers in 32 bits are integers, numbers as small or as large as the floats of colors are floats. The
/// quiet NaN is a missing color, and becomes black.
PackedColors read_packed_color(const Column& column, StopCheck& check, std::vector<std::uint32_t>& out);

/// The kinds of color that a column of floats without a name may hold.
enum class FloatColor : std::uint8_t {
  kNone,    ///< numbers
  kPacked,  ///< colors packed into their bits, 0x00RRGGBB
  kBytes,   ///< four bytes, red first and an alpha of 255 last, as cameras of ZED have them
};
/// Judges by the bits: as numbers, colors are NaN, or far too small or too large to mean something.
FloatColor float_color(const Column& column, std::size_t points, StopCheck& check);

/// The points of a cloud without a packed color, among those that are there. The colors of others are NaN on purpose.
struct MissingColors {
  std::size_t missing = 0, points = 0;
};
MissingColors count_missing_colors(const Column& packed, const Cloud& cloud, StopCheck& check);

}  // namespace segserve::codec
