// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/codec/common/file_statements.hpp"
#include "core/codec/common/position_names.hpp"
#include "core/codec/text/column_numbers.hpp"
#include "core/codec/text/text_cells.hpp"

namespace segserve::codec {

/// The part of a text above the rows of its table.
struct TextStart {
  std::vector<std::string> names;      ///< of the columns; empty if there are none
  std::optional<std::uint64_t> count;  ///< of the rows, as PTS has it
  FileStatements stated;
  TextUnit unit;  ///< of x, y and z, if it stands beside or below their names
  Separator separator = Separator::kSpace;
  std::size_t columns = 0;
  std::size_t titles = 0;                       ///< lines of words above the names
  std::optional<ColumnNumbers> column_numbers;  ///< in the line above the rows
  bool has_tracks = false;  ///< the rows have tracks behind the columns, as COLMAP's points3D.txt has them
  std::size_t offset = 0;   ///< of the first row
  std::size_t line = 1;     ///< of the first row
};

/// Finds the first row. INVALID_ARGUMENT if there is none, or if the lines above it are none of those of a table.
absl::StatusOr<TextStart> find_text_start(std::string_view file);

}  // namespace segserve::codec
