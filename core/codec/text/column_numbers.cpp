// SPDX-License-Identifier: Apache-2.0
#include "core/codec/text/column_numbers.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "core/codec/common/field_roles.hpp"
#include "core/codec/common/header_limits.hpp"
#include "core/codec/common/text_parsing.hpp"
#include "core/codec/text/text_cells.hpp"

namespace segserve::codec {
namespace {

/// The word in front of the number of a column, in small letters; nullopt for other names.
std::optional<std::string> word_of(std::string_view cell) {
  constexpr std::array<std::string_view, 11> kWords{"",  "v",  "var", "x",     "col",    "column",
                                                    "c", "_c", "f",   "field", "column_"};
  const std::size_t digits = cell.find_first_of("0123456789");
  std::string word = lower_case(cell.substr(0, digits));
  if (digits == std::string_view::npos || std::ranges::find(kWords, word) == kWords.end()) return std::nullopt;
  return word;
}

/// Whether the line below the names begins with a number that has decimals.
bool has_decimals_below(std::string_view rest) {
  constexpr std::size_t kEnough = std::size_t{1} << 16U;
  const auto next = LineReader(rest.substr(0, kEnough)).next();
  const std::size_t first = next ? next->text.find_first_not_of("0123456789+-,;| \t\r\"") : std::string_view::npos;
  return first != std::string_view::npos && (next->text[first] == '.' || next->text[first] == 'e');
}

}  // namespace

std::optional<ColumnNumbers> column_numbers(std::string_view line, std::string_view rest) {
  constexpr std::size_t kMoreThanAPoint = 6;
  std::vector<std::string_view> cells = split_cells(line, separator_of(line), kMostHeaderFields + 1);
  const bool has_empty_cell = !cells.empty() && cells[0].empty();
  if (has_empty_cell) cells.erase(cells.begin());
  if (cells.size() < 3) return std::nullopt;
  const auto word = word_of(cells[0]);
  if (!word) return std::nullopt;
  const auto number_of = [&word](std::string_view cell) { return parse_count(cell.substr(word->size())); };
  const auto first = number_of(cells[0]);
  if (!first || *first > (word->empty() ? 0 : 1)) return std::nullopt;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (word_of(cells[i]) != word || number_of(cells[i]) != *first + i) return std::nullopt;
  }
  if (word->empty()) {
    const bool has_separators = line.find_first_of(",;\t|") != std::string_view::npos;
    if (!has_separators || (cells.size() < kMoreThanAPoint && !has_decimals_below(rest))) return std::nullopt;
  }
  return ColumnNumbers{std::string(cells.front()), std::string(cells.back()), cells.size(),
                       has_empty_cell || line.front() == '\t'};
}

}  // namespace segserve::codec
