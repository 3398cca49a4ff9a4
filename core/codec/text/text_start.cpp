// SPDX-License-Identifier: Apache-2.0
#include "core/codec/text/text_start.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/codec/common/header_limits.hpp"
#include "core/codec/common/text_parsing.hpp"
#include "core/codec/text/text_table.hpp"
#include "core/codec/view/view_choice.hpp"

namespace segserve::codec {
namespace {

template <typename... Args>
absl::Status fault(fmt::format_string<Args...> format, Args&&... args) {
  return absl::InvalidArgumentError("text table: " + fmt::format(format, std::forward<Args>(args)...));
}

/// The separator of a line of names, which may have spaces in them.
Separator name_separator(std::string_view line) {
  if (line.find(';') != std::string_view::npos) return Separator::kSemicolon;
  return line.find(',') != std::string_view::npos ? Separator::kComma : Separator::kSpace;
}

bool is_one_of(std::string_view name, char lower) {
  return name.size() == 1 && (name[0] == lower || name[0] == lower - 'a' + 'A');
}

std::vector<std::string_view> names_in(std::string_view line) { return split_cells(line, name_separator(line)); }

/// Whether the first cell of a line is a number, perhaps with a decimal comma.
bool begins_with_number(std::string_view line) {
  const auto cell = CellReader(line, separator_of(line)).next();
  return cell && (parse_number(*cell) || has_decimal_comma(*cell));
}

bool is_count(std::string_view line) {
  const std::string_view word = take_word(line);
  return parse_count(word) && is_blank(line);
}

/// Walks over the lines above the first row.
class StartFinder {
 public:
  explicit StartFinder(std::string_view file) : lines_(file) {}

  absl::StatusOr<TextStart> run() {
    std::size_t offset = 0;
    while (const auto line = lines_.next()) {
      if (is_blank(line->text)) {
      } else if (const auto comment = text_comment(line->text)) {
        take_comment(*comment);
      } else if (is_count(line->text)) {
        if (start_.count) return fault("it begins with two counts, as PTX does; save it as PTS or PLY");
        start_.count = parse_count(split_words(line->text)[0]);
      } else if (begins_with_number(line->text)) {
        start_.offset = offset;
        start_.line = line->number;
        RETURN_IF_ERROR(take_row(line->text));
        return std::move(start_);
      } else {
        RETURN_IF_ERROR(take_names(*line));
      }
      offset = lines_.offset();
    }
    return fault("it has no row of numbers");
  }

 private:
  void take_comment(std::string_view comment) {
    if (const auto view = stated_view(comment)) {
      start_.stated_view = view;
    } else {
      comment_ = comment;
    }
  }

  absl::Status take_names(const LineReader::Line& line) {
    const auto names = names_in(line.text);
    if (!start_.names.empty() || !names_position(names)) {
      return fault("line {} is neither numbers nor the names of columns, x, y and z among them: {}", line.number,
                   quoted(line.text));
    }
    if (names.size() > kMostHeaderFields) return fault("it has more than {} columns", kMostHeaderFields);
    start_.names.assign(names.begin(), names.end());
    return absl::OkStatus();
  }

  absl::Status take_row(std::string_view row) {
    start_.separator = separator_of(row);
    CellReader cells(row, start_.separator);
    while (cells.next()) {
      if (++start_.columns > kMostHeaderFields) return fault("it has more than {} columns", kMostHeaderFields);
    }
    if (start_.names.empty() && comment_.size() < kMostHeaderBytes) {
      const auto names = names_in(comment_);
      if (names.size() == start_.columns && names_position(names)) start_.names.assign(names.begin(), names.end());
    }
    if (start_.names.empty()) {
      if (start_.columns < 3)
        return fault("line {} has {} columns; x, y and z are needed", start_.line, start_.columns);
      return absl::OkStatus();
    }
    start_.columns = start_.names.size();
    return absl::OkStatus();
  }

  LineReader lines_;
  TextStart start_;
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

bool names_position(const std::vector<std::string_view>& names) {
  return std::ranges::all_of(std::string_view("xyz"), [&names](char axis) {
    return std::ranges::any_of(names, [axis](std::string_view name) { return is_one_of(name, axis); });
  });
}

absl::StatusOr<TextStart> find_text_start(std::string_view file) { return StartFinder(file).run(); }

bool is_text_table(std::string_view file) {
  constexpr std::size_t kEnough = std::size_t{1} << 16U;
  LineReader lines(without_byte_order_mark(file.substr(0, kEnough)));
  bool has_count = false;
  while (const auto line = lines.next()) {
    if (is_blank(line->text) || text_comment(line->text)) continue;
    if (is_count(line->text)) {
      if (std::exchange(has_count, true)) return true;  // PTX, which find_text_start names
      continue;
    }
    if (begins_with_number(line->text)) {
      return split_cells(line->text.substr(0, kMostHeaderFields), separator_of(line->text)).size() >= 3;
    }
    const auto names = names_in(line->text.substr(0, kMostHeaderFields));
    const bool is_pcd = names.size() == 1 || line->text.starts_with("FIELDS") || line->text.starts_with("COLUMNS");
    return !is_pcd && names_position(names);
  }
  return false;
}

}  // namespace segserve::codec
