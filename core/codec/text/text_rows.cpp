// SPDX-License-Identifier: Apache-2.0
#include "core/codec/text/text_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/codec/common/limit_checks.hpp"
#include "core/codec/text/text_comments.hpp"

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

/// Counts the rows and reserves memory for them, because memory that grows as they are read is there twice at times.
absl::Status TextRows::make_room(std::string_view rows, StopCheck& check) {
  std::uint64_t count = 0;
  LineReader lines(rows);
  while (const auto line = lines.next()) {
    if (check.after(1)) return check.status();
    if (!is_blank(line->text) && !text_comment(line->text) && !block_count(line->text)) ++count;
  }
  RETURN_IF_ERROR(check_points(kPrefix, count, limits_));
  RETURN_IF_ERROR(check_decoded_points(kPrefix, count, start_.columns * sizeof(double), limits_));
  // A line too short for its columns is a fault, and no reason to reserve much.
  values_.reserve(static_cast<std::size_t>(std::min(count * start_.columns, most_values(rows.size()))));
  return absl::OkStatus();
}

absl::Status TextRows::read(std::string_view file, StopCheck& check) {
  const std::string_view rows = file.substr(start_.offset);
  RETURN_IF_ERROR(make_room(rows, check));
  LineReader lines(rows, start_.line);
  while (const auto line = lines.next()) {
    if (check.after(start_.columns)) return check.status();
    if (is_blank(line->text) || text_comment(line->text)) continue;
    if (const auto count = block_count(line->text)) {
      promised_ = saturating_sum(promised_, *count);
      continue;
    }
    RETURN_IF_ERROR(read_row(*line));
    ++points_;
    const std::size_t bytes = start_.columns * sizeof(double) + integers_.size() * sizeof(std::uint64_t);
    RETURN_IF_ERROR(check_decoded_points(kPrefix, points_, bytes, limits_));
  }
  return absl::OkStatus();
}

Column TextRows::column(std::size_t i) const {
  if (const auto found = integers_.find(i); found != integers_.end()) {
    const Integers& integers = found->second;
    return {reinterpret_cast<const std::byte*>(integers.bits.data()), sizeof(std::uint64_t),
            integers.has_unsigned ? ScalarType::kUint64 : ScalarType::kInt64};
  }
  return {reinterpret_cast<const std::byte*>(values_.data() + i), start_.columns * sizeof(double),
          ScalarType::kFloat64};
}

/// The count in a line that begins another block of PTS; nullopt for other lines.
std::optional<std::uint64_t> TextRows::block_count(std::string_view line) const {
  if (!start_.count) return std::nullopt;
  const auto count = parse_count(take_word(line));
  return is_blank(line) ? count : std::nullopt;
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
  if (const auto cell = cells.next(); cell && !start_.has_tracks) {
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

bool TextRows::Integers::add(std::string_view cell) {
  if (!is_digits(cell)) return false;
  std::uint64_t value = 0;
  auto* const bytes = reinterpret_cast<std::byte*>(&value);
  if (parse_scalar(cell, ScalarType::kInt64, bytes)) {
    has_negative = has_negative || cell.starts_with('-');
  } else if (parse_scalar(cell, ScalarType::kUint64, bytes)) {
    has_unsigned = true;
  } else {
    return false;
  }
  bits.push_back(value);
  return !(has_negative && has_unsigned);
}

/// Keeps the value of a column that has, or now gets, integers beyond 2^53.
void TextRows::keep_integer(std::size_t column, std::string_view cell, double value) {
  if (rounded_.contains(column) || unreadable_.contains(column)) return;
  if (!integers_.contains(column)) {
    if (std::abs(value) < kExactIntegers || !is_digits(cell)) return;
    if (auto begun = integers_so_far(column)) integers_.emplace(column, *std::move(begun));
  }
  const auto found = integers_.find(column);
  if (found != integers_.end() && found->second.add(cell)) return;
  integers_.erase(column);
  rounded_.insert(column);
}

/// The values of a column up to here; nullopt if one of them is no integer.
std::optional<TextRows::Integers> TextRows::integers_so_far(std::size_t column) const {
  Integers integers;
  integers.bits.reserve(values_.capacity() / start_.columns);
  for (std::size_t point = 0; point < points_; ++point) {
    const double value = values_[point * start_.columns + column];
    if (!(std::abs(value) < kExactIntegers) || value != std::trunc(value)) return std::nullopt;
    integers.bits.push_back(static_cast<std::uint64_t>(static_cast<std::int64_t>(value)));
    integers.has_negative = integers.has_negative || value < 0;
  }
  return integers;
}

}  // namespace segserve::codec
