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
#include "core/codec/text/text_cells.hpp"
#include "segserve/codec/length_unit.hpp"

namespace segserve::codec {

/// The part of a text above the rows of its table.
struct TextStart {
  std::vector<std::string> names;      ///< of the columns; empty if there are none
  std::optional<std::uint64_t> count;  ///< of the rows, as PTS has it
  FileStatements stated;
  std::optional<LengthUnit> unit;  ///< of x, y and z, if it stands beside or below their names
  Separator separator = Separator::kSpace;
  std::size_t columns = 0;
  std::size_t titles = 0;          ///< lines of words above the names
  std::size_t column_numbers = 0;  ///< how many numbers of columns, from 0 on, the line above the rows has
  bool has_row_numbers = false;    ///< these numbers leave out the first column, which names the rows
  std::size_t offset = 0;          ///< of the first row
  std::size_t line = 1;            ///< of the first row
};

/// The comment in a line without its mark; nullopt if the line is none.
std::optional<std::string_view> text_comment(std::string_view line);

/// Finds the first row. INVALID_ARGUMENT if there is none, or if the lines above it are none of those of a table.
absl::StatusOr<TextStart> find_text_start(std::string_view file);

}  // namespace segserve::codec
