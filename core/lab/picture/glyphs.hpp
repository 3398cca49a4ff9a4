// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace segserve::picture {

inline constexpr int kGlyphWidth = 5;
inline constexpr int kGlyphHeight = 7;

/// The columns of a character from the left; the lowest bit is the top row.
using Glyph = std::array<std::uint8_t, kGlyphWidth>;

/// The glyph of a character of ASCII; that of "?" for any other.
const Glyph& glyph_of(char character);

}  // namespace segserve::picture
