// SPDX-License-Identifier: Apache-2.0
#include "core/codec/text/text_table.hpp"

#include <fmt/format.h>

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
#include "core/codec/common/limit_checks.hpp"
#include "core/codec/common/point_columns.hpp"
#include "core/codec/common/text_parsing.hpp"
#include "core/codec/common/unnamed_columns.hpp"
#include "core/codec/text/text_cells.hpp"
#include "core/codec/text/text_start.hpp"

namespace segserve::codec {
namespace {

constexpr std::string_view kPrefix = "text table: ";

template <typename... Args>
absl::Status fault(fmt::format_string<Args...> format, Args&&... args) {
  return absl::InvalidArgumentError(std::string(kPrefix) + fmt::format(format, std::forward<Args>(args)...));
}

/// Reads the rows of a table into memory, row by row.
class TextRows {
 public:
  TextRows(const TextStart& start, const DecodeLimits& limits) : start_(start), limits_(limits) {
    promised_ = start.count.value_or(0);
  }

  absl::Status read(std::string_view file, StopCheck& check) {
    LineReader lines(file.substr(start_.offset), start_.line);
    while (const auto line = lines.next()) {
      if (check.after(start_.columns)) return check.status();
      if (is_blank(line->text) || text_comment(line->text)) continue;
      if (start_.count && is_block_count(line->text)) continue;
      RETURN_IF_ERROR(read_row(*line));
      ++points_;
      RETURN_IF_ERROR(check_points(kPrefix, points_, limits_));
      RETURN_IF_ERROR(check_decoded_points(kPrefix, points_, start_.columns * sizeof(double), limits_));
    }
    return absl::OkStatus();
  }

  std::size_t points() const { return points_; }
  std::uint64_t promised() const { return promised_; }
  /// Columns with words that are no numbers, and the first such word of each.
  const std::map<std::size_t, std::string>& unreadable() const { return unreadable_; }
  Column column(std::size_t i) const {
    return {reinterpret_cast<const std::byte*>(values_.data() + i), start_.columns * sizeof(double),
            ScalarType::kFloat64};
  }

 private:
  /// A line with one count begins another block of PTS.
  bool is_block_count(std::string_view line) {
    const std::string_view word = take_word(line);
    const auto count = parse_count(word);
    if (!count || !is_blank(line)) return false;
    promised_ = saturating_sum(promised_, *count);
    return true;
  }

  std::string name_of(std::size_t column) const {
    return column < start_.names.size() ? quoted(start_.names[column]) : fmt::format("column {}", column + 1);
  }

  absl::Status read_row(const LineReader::Line& line) {
    CellReader cells(line.text, start_.separator);
    for (std::size_t i = 0; i < start_.columns; ++i) {
      const auto cell = cells.next();
      if (!cell || cell->empty()) {
        return fault("line {}: the value of {} is missing; nan stands for one that is unknown", line.number,
                     name_of(i));
      }
      const auto value = parse_number(*cell);
      if (!value) RETURN_IF_ERROR(take_word_without_number(line.number, *cell, i));
      values_.push_back(value.value_or(0));
    }
    if (const auto cell = cells.next()) {
      return fault("line {}: {} is one value too many; the rows have {}", line.number, quoted(*cell), start_.columns);
    }
    return absl::OkStatus();
  }

  absl::Status take_word_without_number(std::size_t line, std::string_view cell, std::size_t column) {
    if (has_decimal_comma(cell)) {
      return fault("line {}: {} has a decimal comma; numbers need a decimal point", line, quoted(cell));
    }
    if (unreadable_.contains(column)) return absl::OkStatus();
    std::string words = fmt::format("line {}: {} is not a value of {}", line, quoted(cell), name_of(column));
    if (start_.names.empty() && column < 3) return fault("{}", words);
    unreadable_.emplace(column, std::move(words));
    return absl::OkStatus();
  }

  const TextStart& start_;
  const DecodeLimits& limits_;
  std::vector<double> values_;
  std::size_t points_ = 0;
  std::uint64_t promised_ = 0;
  std::map<std::size_t, std::string> unreadable_;
};

/// The names of the columns; numbers of columns of words are not looked at.
std::vector<std::string> names_of(const TextStart& start, const TextRows& rows, StopCheck& check,
                                  std::vector<Warning>& warnings) {
  if (!start.names.empty()) return start.names;
  std::vector<Column> columns;
  const std::size_t readable = rows.unreadable().empty() ? start.columns : rows.unreadable().begin()->first;
  for (std::size_t i = 0; i < readable; ++i) columns.push_back(rows.column(i));
  std::vector<std::string> names = name_columns(columns, rows.points(), check, warnings);
  for (std::size_t i = names.size(); i < start.columns; ++i) names.push_back(fmt::format("column_{}", i + 1));
  return names;
}

absl::StatusOr<PointTable> make_table(const std::vector<std::string>& names, const TextRows& rows,
                                      std::vector<Warning>& warnings) {
  PointTable table;
  for (const std::string& name : names) table.fields.push_back({name, ScalarType::kFloat64});
  auto roles = find_field_roles(table.fields, warnings);
  if (!roles.ok()) return fault("{}", std::string(roles.status().message()));
  table.roles = *std::move(roles);
  for (const std::size_t used : table.roles.fields()) {
    const auto found = rows.unreadable().find(used);
    if (found != rows.unreadable().end()) return fault("{}", found->second);
  }
  std::set<std::size_t> unreadable;
  for (const auto& [column, words] : rows.unreadable()) unreadable.insert(column);
  leave_out(unreadable, table.fields, warnings);
  table.width = static_cast<std::uint32_t>(rows.points());
  table.height = 1;
  table.column = [&rows](std::size_t i) { return rows.column(i); };
  return table;
}

}  // namespace

absl::StatusOr<LabeledCloud> decode_text_table(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                               const ReadOptions& options, const StopToken& stop) {
  RETURN_IF_ERROR(check_bytes(kPrefix, bytes.size(), limits));
  const std::string_view file = without_byte_order_mark(as_text(bytes));
  ASSIGN_OR_RETURN(const TextStart start, find_text_start(file));
  StopCheck check(stop);
  TextRows rows(start, limits);
  RETURN_IF_ERROR(rows.read(file, check));
  LabeledCloud out;
  if (start.count && rows.promised() != rows.points()) {
    out.warnings.push_back({WarningReason::kRowsNotUsed,
                            fmt::format("{} points are promised, and {} are there", rows.promised(), rows.points())});
  }
  const std::vector<std::string> names = names_of(start, rows, check, out.warnings);
  RETURN_IF_ERROR(check.status());
  ASSIGN_OR_RETURN(const PointTable table, make_table(names, rows, out.warnings));
  RETURN_IF_ERROR(read_points(table, {.stated = start.stated_view}, options, stop, out));
  return out;
}

}  // namespace segserve::codec
