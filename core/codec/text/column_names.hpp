// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/codec/text/text_cells.hpp"

namespace segserve::codec {

/// The names of the columns of a table.
struct ColumnNames {
  std::vector<std::string> names;
  Separator separator = Separator::kSpace;  ///< between the names

  /// Where x, y and z are among the names, in any case.
  std::optional<std::array<std::size_t, 3>> position() const;
};

/// Which names of coordinates are known, for messages.
inline constexpr std::string_view kKnownPositions = "x y z, Points:0 Points:1 Points:2, or easting northing elevation";

/// The names in a line. Units behind a name, such as [m] or (m), are left out. Names that other programs give to
/// coordinates and colors, such as Points:0 and RGB:0 of ParaView, or easting, become x, y, z, red, green and blue.
/// Reads no more than one name beyond kMostHeaderFields.
ColumnNames column_names(std::string_view line);

}  // namespace segserve::codec
