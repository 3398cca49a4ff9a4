// SPDX-License-Identifier: Apache-2.0
#include "core/codec/text/text_rows.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/codec/common/limit_checks.hpp"

namespace segserve::codec {
namespace {

constexpr std::string_view kPrefix = "text table: ";

/// From here on, doubles are not all integers.
constexpr double kExactIntegers = 9007199254740992;

template <typename... Args>
absl::Status fault(fmt::format_string<Args...> format, Args&&... args) {
  return absl::InvalidArgumentError(std::string(kPrefix) + fmt::format(format, std::forward<Args>(args)...));
}

bool is_digits(std::string_view word) {
  if (word.starts_with('-') || word.starts_with('+')) word.remove_prefix(1);
  return !word.empty() && word.find_first_not_of("0123456789") == std::string_view::npos;
}

}  // namespace

absl::Status TextRows::read(std::string_view file, StopCheck& check) {
  LineReader lines(file.substr(start_.offset), start_.line);
  while (const auto line = lines.next()) {
    if (check.after(start_.columns)) return check.status();
    if (is_blank(line->text) || text_comment(line->text)) continue;
    if (start_.count && is_block_count(line->text)) continue;
    RETURN_IF_ERROR(read_row(*line));
    ++points_;
    RETURN_IF_ERROR(check_points(kPrefix, points_, limits_));
    const std::size_t bytes = start_.columns * sizeof(double) + integers_.size() * sizeof(std::int64_t);
    RETURN_IF_ERROR(check_decoded_points(kPrefix, points_, bytes, limits_));
  }
  return absl::OkStatus();
}

Column TextRows::column(std::size_t i) const {
  if (const auto found = integers_.find(i); found != integers_.end()) {
    return {reinterpret_cast<const std::byte*>(found->second.data()), sizeof(std::int64_t), ScalarType::kInt64};
  }
  return {reinterpret_cast<const std::byte*>(values_.data() + i), start_.columns * sizeof(double),
          ScalarType::kFloat64};
}

/// A line with one count begins another block of PTS.
bool TextRows::is_block_count(std::string_view line) {
  const std::string_view word = take_word(line);
  const auto count = parse_count(word);
  if (!count || !is_blank(line)) return false;
  promised_ = saturating_sum(promised_, *count);
  return true;
}

std::string TextRows::name_of(std::size_t column) const {
  return column < start_.names.size() ? quoted(start_.names[column]) : fmt::format("column {}", column + 1);
}

absl::Status TextRows::read_row(const LineReader::Line& line) {
  CellReader cells(line.text, start_.separator);
  for (std::size_t i = 0; i < start_.columns; ++i) {
    auto cell = cells.next();
    if (!cell && i + 1 == start_.columns && cells.ended_with_separator()) cell = std::string_view();
    if (!cell) {
      return fault("line {}: the value of {} is missing; nan stands for one that is unknown", line.number, name_of(i));
    }
    const auto value = parse_cell(*cell, start_.separator);
    if (!value) RETURN_IF_ERROR(take_word_without_number(line.number, *cell, i));
    if (value && (std::abs(*value) >= kExactIntegers || !integers_.empty())) keep_integer(i, *cell, *value);
    values_.push_back(value.value_or(0));
  }
  if (const auto cell = cells.next()) {
    return fault("line {}: {} is one value too many; the rows have {}", line.number, quoted(*cell), start_.columns);
  }
  return absl::OkStatus();
}

absl::Status TextRows::take_word_without_number(std::size_t line, std::string_view cell, std::size_t column) {
  integers_.erase(column);
  if (has_decimal_comma(cell)) {
    return fault(
        "line {}: {} has a decimal comma, but commas separate values here; semicolons or a decimal point are "
        "needed",
        line, quoted(cell));
  }
  if (unreadable_.contains(column)) return absl::OkStatus();
  std::string words = fmt::format("line {}: {} is not a value of {}", line, quoted(cell), name_of(column));
  if (start_.names.empty() && column < 3) return fault("{}", words);
  unreadable_.emplace(column, std::move(words));
  return absl::OkStatus();
}

/// Keeps the value of a column that has, or now gets, integers beyond 2^53.
void TextRows::keep_integer(std::size_t column, std::string_view cell, double value) {
  const bool is_begun = integers_.contains(column);
  if (rounded_.contains(column) || unreadable_.contains(column)) return;
  if (!is_begun && (std::abs(value) < kExactIntegers || !is_digits(cell))) return;
  std::int64_t integer = 0;
  const bool is_integer =
      is_digits(cell) && parse_scalar(cell, ScalarType::kInt64, reinterpret_cast<std::byte*>(&integer));
  if (is_integer && (is_begun || begin_integers(column))) {
    integers_[column].push_back(integer);
  } else {
    integers_.erase(column);
    rounded_.insert(column);
  }
}

/// Begins to keep a column as integers. Returns false if one of its values up to here is none.
bool TextRows::begin_integers(std::size_t column) {
  std::vector<std::int64_t> integers;
  for (std::size_t point = 0; point < points_; ++point) {
    const double value = values_[point * start_.columns + column];
    if (!(std::abs(value) < kExactIntegers) || value != std::trunc(value)) return false;
    integers.push_back(static_cast<std::int64_t>(value));
  }
  integers_.emplace(column, std::move(integers));
  return true;
}

}  // namespace segserve::codec
