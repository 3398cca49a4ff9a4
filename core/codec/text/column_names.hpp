// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/codec/common/position_names.hpp"
#include "core/codec/text/text_cells.hpp"

namespace segserve::codec {

/// The names of the columns of a table.
struct ColumnNames {
  std::vector<std::string> names;
  Separator separator = Separator::kSpace;  ///< between the names
  TextUnit unit = {};                       ///< of x, y and z, if it stands behind their names

  /// Where x, y and z are among the names, in any case.
  std::optional<std::array<std::size_t, 3>> position() const;
};

/// The names in a line. Units behind a name, such as [m] or (m), are left out. Names that other programs give to
/// coordinates (find_position_names) and colors, such as RGB:0 of ParaView, become x, y, z, red, green and blue. Reads
/// no more than one name beyond kMostHeaderFields.
ColumnNames column_names(std::string_view line);

}  // namespace segserve::codec
