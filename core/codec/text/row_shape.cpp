// SPDX-License-Identifier: Apache-2.0
#include "core/codec/text/row_shape.hpp"

#include <algorithm>
#include <vector>

#include "core/codec/common/header_limits.hpp"

namespace segserve::codec {
namespace {

/// The cells of a row, with an empty one behind a separator at its end if it is one short of `wanted`.
std::vector<std::string_view> row_cells(std::string_view line, Separator separator, std::size_t wanted) {
  std::vector<std::string_view> cells;
  CellReader reader(line, separator);
  while (cells.size() < wanted + 2) {
    const auto cell = reader.next();
    if (!cell) break;
    cells.push_back(*cell);
  }
  if (cells.size() + 1 == wanted && reader.ended_with_separator()) cells.emplace_back();
  return cells;
}

}  // namespace

bool is_row_without_names(std::string_view line) {
  const Separator separator = separator_of(line);
  CellReader cells(line, separator);
  auto cell = cells.next();
  if (!cell) return false;
  const auto is_number = [](std::string_view text) { return parse_number(text) || has_decimal_comma(text); };
  if (is_number(*cell)) return true;
  std::size_t count = 0, numbers = 0;
  for (; cell && count <= kMostHeaderFields; cell = cells.next(), ++count) {
    if (!parse_cell(*cell, separator)) return false;
    if (is_number(*cell)) ++numbers;
  }
  return count >= 3 && numbers > 0;
}

std::size_t numbers_in(std::string_view line) {
  const Separator separator = separator_of(line);
  const auto cells = split_cells(line, separator, kMostHeaderFields);
  return static_cast<std::size_t>(std::ranges::count_if(
      cells, [separator](std::string_view cell) { return !cell.empty() && parse_cell(cell, separator); }));
}

std::optional<NamedRow> named_row(const ColumnNames& names, std::string_view line) {
  const auto position = names.position();
  const std::size_t wanted = names.names.size();
  if (!position) return std::nullopt;
  for (const Separator separator : {names.separator, separator_of(line)}) {
    const auto cells = row_cells(line, separator, wanted);
    if (cells.size() != wanted && cells.size() != wanted + 1) continue;
    const std::size_t before = cells.size() - wanted;
    const bool is_row = std::ranges::all_of(
        *position, [&](std::size_t axis) { return parse_cell(cells[before + axis], separator).has_value(); });
    if (is_row) return NamedRow{separator, before};
  }
  return std::nullopt;
}

}  // namespace segserve::codec
