// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include "core/codec/text/column_names.hpp"
#include "core/codec/text/text_cells.hpp"

// The shape by which a line is recognized as a row of a table.
namespace segserve::codec {

/// Whether a line without names above it is a row: its first cell is a number, or it begins with cells that are empty
/// or stand for a number that is not known, and all others are numbers.
bool is_row_without_names(std::string_view line);

/// How many numbers a line has among its first cells.
std::size_t numbers_in(std::string_view line);

/// How a line is read as a row of columns with names.
struct NamedRow {
  Separator separator = Separator::kSpace;
  std::size_t before = 0;  ///< cells before the first column that has a name
};

/// Nullopt unless the line has as many cells as there are names, or one more in front, and its position is numbers or
/// left out.
std::optional<NamedRow> named_row(const ColumnNames& names, std::string_view line);

}  // namespace segserve::codec
