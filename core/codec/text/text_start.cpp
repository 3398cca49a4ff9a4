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
#include "core/codec/text/column_numbers.hpp"
#include "core/codec/text/row_shape.hpp"
#include "core/codec/text/text_comments.hpp"
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

/// Whether a line has a number such as 499,999.5, 5.399.999,98 or 499'999.99, with thousands set apart.
bool has_grouped_number(std::string_view line) {
  const auto is_digit = [&line](std::size_t i) { return i < line.size() && line[i] >= '0' && line[i] <= '9'; };
  // Typographic signs are several bytes: no-break space, narrow no-break space, apostrophe.
  constexpr std::array<std::string_view, 6> kSigns{".", ",", "'", "\u00a0", "\u202f", "\u2019"};
  for (std::size_t i = 1; i < line.size(); ++i) {
    if (!is_digit(i - 1)) continue;
    for (const std::string_view sign : kSigns) {
      if (!line.substr(i).starts_with(sign)) continue;
      const std::size_t at = i + sign.size();
      const bool has_group = is_digit(at) && is_digit(at + 1) && is_digit(at + 2) && !is_digit(at + 3);
      const bool goes_on = at + 3 < line.size() && (line[at + 3] == '.' || line[at + 3] == ',') && is_digit(at + 4);
      if (has_group && goes_on && line[at + 3] != sign[0]) return true;
    }
  }
  return false;
}

/// Whether a line of dashes, or of their like, is a rule below names. Between separators, one or two dashes are numbers
/// that are not known.
bool is_rule(std::string_view line) {
  const bool has_others = line.find_first_not_of("-_=:|,;+ \t") != std::string_view::npos;
  if (has_others || line.find_first_of("-_=") == std::string_view::npos) return false;
  return line.find_first_of("_=") != std::string_view::npos || line.find("---") != std::string_view::npos ||
         line.find_first_of(",;\t") == std::string_view::npos;
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
        start_.column_numbers = numbers;
      } else if (!is_rule(line->text) && (named_row(names_, line->text) || is_row_without_names(line->text))) {
        start_.offset = offset;
        start_.line = line->number;
        RETURN_IF_ERROR(take_row(line->text));
        start_.unit = names_.unit;
        start_.names = std::move(names_.names);
        return std::move(start_);
      } else if (const auto remark = comment_above_rows(line->text, file_.substr(lines_.offset()))) {
        take_comment(*remark);
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
    if (!names_.names.empty() || start_.column_numbers) return std::nullopt;
    return column_numbers(line, file_.substr(lines_.offset()));
  }

  void take_comment(std::string_view comment) {
    if (start_.stated.take(comment)) return;
    if (is_colmap_header(comment)) start_.has_tracks = true;
    comment_ = comment;
  }

  /// Whether a line below the names has the units of the columns, which are noted, or is a rule of dashes.
  bool is_below_names(std::string_view line) {
    const auto position = names_.position();
    if (!position) return false;
    if (is_rule(line)) return true;
    const auto cells = split_cells(line, names_.separator, kMostHeaderFields + 1);
    if (cells.size() > names_.names.size()) return false;
    std::array<std::string_view, 3> texts;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t column = (*position)[axis];
      if (column < cells.size()) texts[axis] = cells[column];
    }
    const bool are_units = std::ranges::all_of(texts, [](auto text) { return unit_in_words(text).has_value(); });
    const bool are_alike = !texts[0].empty() && texts[0] == texts[1] && texts[0] == texts[2];
    if (!are_units && !are_alike) return false;
    names_.unit = unit_of_words(texts);
    return true;
  }

  absl::Status take_names(const LineReader::Line& line) {
    ColumnNames names = column_names(line.text);
    if (!names.position() && are_degrees({names.names.begin(), names.names.end()})) {
      return fault("line {}: {}", line.number, kDegreesAreRefused);
    }
    if (!names_.names.empty() && has_grouped_number(line.text)) {
      return fault("line {} has numbers with separators of thousands, {}; write them without", line.number,
                   quoted(line.text));
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
    if (start_.has_tracks) {
      start_.columns = kColmapColumns.size();
      names_.names.assign(kColmapColumns.begin(), kColmapColumns.end());
      return absl::OkStatus();
    }
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
    auto& numbers = start_.column_numbers;
    if (numbers && numbers->count + 1 == start_.columns) numbers->has_row_numbers = true;
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
    const std::string_view rest = file.substr(std::min(lines.offset(), file.size()));
    if (comment_above_rows(line->text, rest)) continue;
    if (column_numbers(line->text, rest) || is_title(line->text, rest)) return TableKind::kPoints;
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
