// SPDX-License-Identifier: Apache-2.0
#include "core/codec/text/text_cells.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <string>

#include "core/codec/common/text_parsing.hpp"

namespace segserve::codec {
namespace {

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r";
  const std::size_t begin = text.find_first_not_of(kSpace);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kSpace) - begin + 1);
}

/// Where the cell at the beginning of `text` ends, so that a separator within quotation marks does not count.
std::size_t cell_end(std::string_view text, char separator) {
  const std::size_t begin = std::min(text.find_first_not_of(separator == '\t' ? " " : " \t"), text.size());
  std::size_t from = begin;
  if (text.substr(begin).starts_with('"')) {
    const std::size_t quote = text.find('"', begin + 1);
    from = quote == std::string_view::npos ? text.size() : quote;
  }
  return std::min(text.find(separator, from), text.size());
}

char character_of(Separator separator) {
  switch (separator) {
    case Separator::kSpace:
      break;
    case Separator::kTab:
      return '\t';
    case Separator::kComma:
      return ',';
    case Separator::kSemicolon:
      return ';';
    case Separator::kBar:
      return '|';
  }
  return ' ';
}

/// What programs write for a number that is unknown.
bool is_unknown(std::string_view cell) {
  constexpr std::array<std::string_view, 20> kWords{"",     "NA",   "N/A",     "n/a",     "#N/A",  "<NA>",  "null",
                                                    "NULL", "Null", "None",    "none",    "#NUM!", "#NV",   "-",
                                                    "--",   "?",    "#VALUE!", "#DIV/0!", "#REF!", "#NAME?"};
  return std::ranges::find(kWords, cell) != kWords.end();
}

std::string with_decimal_point(std::string_view word) {
  std::string text(word);
  std::ranges::replace(text, ',', '.');
  return text;
}

std::string_view without_quotes(std::string_view cell) {
  const bool is_quoted = cell.size() >= 2 && cell.front() == '"' && cell.back() == '"';
  return is_quoted ? trimmed(cell.substr(1, cell.size() - 2)) : cell;
}

}  // namespace

std::optional<double> parse_number(std::string_view word) {
  double value = 0;
  if (!parse_scalar(word, ScalarType::kFloat64, reinterpret_cast<std::byte*>(&value))) return std::nullopt;
  return value;
}

bool has_decimal_comma(std::string_view word) {
  constexpr std::size_t kLongest = 64;
  if (word.size() > kLongest || word.ends_with(',') || std::ranges::count(word, ',') != 1) return false;
  return parse_number(with_decimal_point(word)).has_value();
}

std::optional<double> parse_cell(std::string_view cell, Separator separator) {
  if (const auto number = parse_number(cell)) return number;
  if (is_unknown(cell)) return std::numeric_limits<double>::quiet_NaN();
  if (separator == Separator::kComma || !has_decimal_comma(cell)) return std::nullopt;
  return parse_number(with_decimal_point(cell));
}

Separator separator_of(std::string_view line) {
  if (line.find(';') != std::string_view::npos) return Separator::kSemicolon;
  const std::size_t bar = line.find('|');
  if (bar != std::string_view::npos && parse_cell(trimmed(line.substr(0, bar)), Separator::kBar)) {
    return Separator::kBar;
  }
  if (line.find(',') == std::string_view::npos) return Separator::kSpace;
  std::string_view rest = line;
  for (int i = 0; i < 3; ++i) {
    const std::string_view word = take_word(rest);
    if (!has_decimal_comma(word) && (word.empty() || word.find(',') != std::string_view::npos))
      return Separator::kComma;
  }
  return Separator::kSpace;
}

std::optional<std::string_view> CellReader::next() {
  if (separator_ == Separator::kSpace) {
    const std::string_view word = take_word(rest_);
    if (word.empty()) return std::nullopt;
    return without_quotes(word);
  }
  if (separator_ == Separator::kTab ? rest_.find_first_not_of(" \r") == std::string_view::npos : is_blank(rest_)) {
    return std::nullopt;
  }
  const std::size_t end = cell_end(rest_, character_of(separator_));
  ended_with_separator_ = end < rest_.size();
  const std::string_view cell = trimmed(rest_.substr(0, end));
  rest_.remove_prefix(std::min(end + 1, rest_.size()));
  return without_quotes(cell);
}

std::vector<std::string_view> split_cells(std::string_view line, Separator separator, std::size_t most) {
  std::vector<std::string_view> cells;
  CellReader reader(line, separator);
  while (cells.size() < most) {
    const auto cell = reader.next();
    if (!cell) break;
    cells.push_back(*cell);
  }
  return cells;
}

}  // namespace segserve::codec
