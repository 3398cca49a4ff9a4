// SPDX-License-Identifier: Apache-2.0
#include "core/codec/text/text_start.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/codec/common/header_limits.hpp"
#include "core/codec/common/position_names.hpp"
#include "core/codec/common/text_parsing.hpp"
#include "core/codec/text/column_names.hpp"
#include "core/codec/text/row_shape.hpp"
#include "core/codec/text/text_table.hpp"

namespace segserve::codec {
namespace {

template <typename... Args>
absl::Status fault(fmt::format_string<Args...> format, Args&&... args) {
  return absl::InvalidArgumentError("text table: " + fmt::format(format, std::forward<Args>(args)...));
}

/// Whether Excel is told here what separates cells.
bool is_separator_line(std::string_view line) { return line.starts_with("sep=") && line.size() <= 6; }

bool is_count(std::string_view line) {
  const std::string_view word = take_word(line);
  return parse_count(word) && is_blank(line);
}

/// Whether a line is one of the header of a PCD file that could be taken for names.
bool is_pcd_entry(std::string_view line) {
  constexpr std::array<std::string_view, 6> kEntries{"FIELDS", "COLUMNS", "SIZE", "TYPE", "COUNT", "VIEWPOINT"};
  return std::ranges::find(kEntries, take_word(line)) != kEntries.end();
}

/// Whether a line of words is a title: names of columns stand in one of the next lines, with a row below them.
bool is_title(std::string_view line, std::string_view rest) {
  constexpr std::size_t kMostTitles = 32, kEnough = std::size_t{1} << 16U;
  const auto has_names = [](std::string_view text) {
    return column_names(text.substr(0, kMostHeaderBytes)).position() && !is_pcd_entry(text);
  };
  if (is_pcd_entry(line) || has_names(line)) return false;
  LineReader lines(rest.substr(0, kEnough));
  std::optional<ColumnNames> names;
  for (std::size_t i = 0; i < kMostTitles; ++i) {
    const auto next = lines.next();
    if (!next) return false;
    if (is_blank(next->text)) continue;
    if (names) return named_row(*names, next->text).has_value();
    if (has_names(next->text)) names = column_names(next->text);
  }
  return false;
}

/// Which columns a line of their numbers is for.
struct ColumnNumbers {
  std::size_t count = 0;
  bool has_row_numbers = false;  ///< an empty cell stands before them
};

/// Whether a line is one of names that pandas makes up, 0,1,2 and so on, maybe behind an empty cell, and no first
/// point: the next line has decimals, or the numbers are more than a point would have.
std::optional<ColumnNumbers> column_numbers(std::string_view line, std::string_view rest) {
  constexpr std::size_t kMoreThanAPoint = 6, kEnough = std::size_t{1} << 16U;
  if (line.find_first_of(",;\t|") == std::string_view::npos) return std::nullopt;
  std::vector<std::string_view> cells = split_cells(line, separator_of(line), kMostHeaderFields + 1);
  const bool has_empty_cell = !cells.empty() && cells[0].empty();
  if (has_empty_cell) cells.erase(cells.begin());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (parse_count(cells[i]) != i) return std::nullopt;
  }
  if (cells.size() < 3) return std::nullopt;
  const auto next = LineReader(rest.substr(0, kEnough)).next();
  const std::size_t first = next ? next->text.find_first_not_of("0123456789+-,;| \t\r\"") : std::string_view::npos;
  const bool has_decimals = first != std::string_view::npos && (next->text[first] == '.' || next->text[first] == 'e');
  if (!has_decimals && cells.size() < kMoreThanAPoint) return std::nullopt;
  return ColumnNumbers{cells.size(), has_empty_cell || line.front() == '\t'};
}

/// Walks over the lines above the first row.
class StartFinder {
 public:
  explicit StartFinder(std::string_view file) : file_(file), lines_(file) {}

  absl::StatusOr<TextStart> run() {
    std::size_t offset = 0;
    while (const auto line = lines_.next()) {
      if (is_blank(line->text) || (names_.names.empty() && is_separator_line(line->text))) {
      } else if (const auto comment = text_comment(line->text)) {
        take_comment(*comment);
      } else if (is_count(line->text)) {
        if (start_.count) return fault("it begins with two counts, as PTX does; save it as PTS or PLY");
        start_.count = parse_count(split_words(line->text)[0]);
      } else if (const auto numbers = column_numbers_above_rows(line->text)) {
        start_.column_numbers = numbers->count;
        start_.has_row_numbers = numbers->has_row_numbers;
      } else if (named_row(names_, line->text) || is_row_without_names(line->text)) {
        start_.offset = offset;
        start_.line = line->number;
        RETURN_IF_ERROR(take_row(line->text));
        start_.unit = names_.unit;
        start_.names = std::move(names_.names);
        return std::move(start_);
      } else if (names_.names.empty() && is_title(line->text, file_.substr(lines_.offset()))) {
        ++start_.titles;
      } else if (!is_below_names(line->text)) {
        RETURN_IF_ERROR(take_names(*line));
      }
      offset = lines_.offset();
    }
    return fault("it has no row of numbers");
  }

 private:
  std::optional<ColumnNumbers> column_numbers_above_rows(std::string_view line) const {
    if (!names_.names.empty() || start_.column_numbers > 0) return std::nullopt;
    return column_numbers(line, file_.substr(lines_.offset()));
  }

  void take_comment(std::string_view comment) {
    if (!start_.stated.take(comment)) comment_ = comment;
  }

  /// Whether a line below the names has the units of the columns, which are noted, or is a rule of dashes.
  bool is_below_names(std::string_view line) {
    const auto position = names_.position();
    if (!position) return false;
    if (line.find_first_not_of("-:|,;+ \t") == std::string_view::npos) return true;
    const auto cells = split_cells(line, names_.separator, kMostHeaderFields + 1);
    if (cells.size() > names_.names.size()) return false;
    std::array<std::optional<LengthUnit>, 3> units;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t column = (*position)[axis];
      if (column < cells.size()) units[axis] = unit_in_words(cells[column]);
    }
    if (!units[0] || units[0] != units[1] || units[0] != units[2]) return false;
    names_.unit = units[0];
    return true;
  }

  absl::Status take_names(const LineReader::Line& line) {
    ColumnNames names = column_names(line.text);
    if (are_degrees({names.names.begin(), names.names.end()})) {
      return fault("line {}: {}", line.number, kDegreesAreRefused);
    }
    if (!names_.names.empty() || !names.position()) {
      return fault(
          "line {} is neither numbers nor the names of columns, x, y and z among them: {}; names that are "
          "known are {}",
          line.number, quoted(line.text), kKnownPositions);
    }
    if (names.names.size() > kMostHeaderFields) return too_many_columns();
    names_ = std::move(names);
    return absl::OkStatus();
  }

  absl::Status take_row(std::string_view row) {
    const bool has_names = !names_.names.empty();
    const std::size_t columns = has_names ? 0 : split_cells(row, separator_of(row), kMostHeaderFields + 1).size();
    if (columns > kMostHeaderFields) return too_many_columns();
    if (!has_names && comment_.size() < kMostHeaderBytes) {
      ColumnNames names = column_names(comment_);
      if (names.names.size() == columns && names.position()) names_ = std::move(names);
    }
    const auto named = named_row(names_, row);
    start_.separator = named ? named->separator : separator_of(row);
    if (named && named->before > 0 && are_row_names(row)) names_.names.insert(names_.names.begin(), "");
    start_.columns = names_.names.empty() ? columns : names_.names.size();
    if (start_.columns >= 3) return absl::OkStatus();
    return fault("line {} has {} columns; x, y and z are needed", start_.line, start_.columns);
  }

  /// Whether the first cell of a row with one cell more than there are names tells rows apart, as programs write it: a
  /// word in quotation marks, or an integer that is another one in the next row.
  bool are_row_names(std::string_view row) const {
    if (std::string_view words = row; take_word(words).starts_with('"')) return true;
    const auto first_cell = [this](std::string_view line) {
      return CellReader(line, start_.separator).next().value_or(std::string_view());
    };
    const auto first = parse_count(first_cell(row));
    LineReader rows(file_.substr(start_.offset));
    rows.next();
    const auto line = rows.next();
    const auto second = line ? parse_count(first_cell(line->text)) : std::nullopt;
    return first && (second ? *first != *second : !line);
  }

  static absl::Status too_many_columns() { return fault("it has more than {} columns", kMostHeaderFields); }

  std::string_view file_;
  LineReader lines_;
  TextStart start_;
  ColumnNames names_;
  std::string_view comment_;
};

}  // namespace

std::optional<std::string_view> text_comment(std::string_view line) {
  const std::size_t begin = line.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return std::nullopt;
  line.remove_prefix(begin);
  const bool is_comment = line.starts_with('#') || line.starts_with("//");
  if (!is_comment) return std::nullopt;
  const std::size_t text = line.find_first_not_of("#/ \t");
  return text == std::string_view::npos ? std::string_view() : line.substr(text);
}

absl::StatusOr<TextStart> find_text_start(std::string_view file) { return StartFinder(file).run(); }

TableKind table_kind(std::string_view file) {
  constexpr std::size_t kEnough = std::size_t{1} << 16U;
  LineReader lines(without_byte_order_mark(file.substr(0, kEnough)));
  bool has_count = false, has_names = false;
  while (const auto line = lines.next()) {
    if (is_blank(line->text) || text_comment(line->text) || is_separator_line(line->text)) continue;
    const std::string_view begin = line->text.substr(0, kMostHeaderFields);
    if (has_names) return numbers_in(begin) >= 3 ? TableKind::kNoPoints : TableKind::kNone;
    if (is_count(line->text)) {
      if (std::exchange(has_count, true)) return TableKind::kPoints;  // PTX, which find_text_start names
      continue;
    }
    if (is_row_without_names(begin)) {
      return split_cells(begin, separator_of(begin)).size() >= 3 ? TableKind::kPoints : TableKind::kNone;
    }
    if (is_title(line->text, file.substr(lines.offset()))) return TableKind::kPoints;
    const ColumnNames names = column_names(begin);
    if (names.names.size() == 1 || is_pcd_entry(begin)) return TableKind::kNone;
    if (names.position()) return TableKind::kPoints;
    // Names that find_text_start does not know are those of a table if numbers follow.
    const auto is_number = [](const std::string& name) { return parse_number(name).has_value(); };
    if (names.names.size() < 3 || std::ranges::any_of(names.names, is_number)) return TableKind::kNone;
    has_names = true;
  }
  return TableKind::kNone;
}

bool is_text_table(std::string_view file) { return table_kind(file) != TableKind::kNone; }

}  // namespace segserve::codec
