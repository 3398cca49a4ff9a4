// SPDX-License-Identifier: Apache-2.0
#include "core/codec/text/text_comments.hpp"

#include <algorithm>
#include <cstddef>

#include "core/codec/common/header_limits.hpp"
#include "core/codec/common/text_parsing.hpp"
#include "core/codec/text/column_names.hpp"
#include "core/codec/text/row_shape.hpp"
#include "core/codec/text/text_cells.hpp"

namespace segserve::codec {
namespace {

constexpr std::string_view kBlank = " \t";

std::string_view without_indent(std::string_view line) {
  return line.substr(std::min(line.find_first_not_of(kBlank), line.size()));
}

/// The line without the characters of the mark and blanks at its beginning.
std::string_view without_mark(std::string_view line, std::string_view mark) {
  while (!line.empty() &&
         (mark.find(line[0]) != std::string_view::npos || kBlank.find(line[0]) != std::string_view::npos))
    line.remove_prefix(1);
  return line;
}

/// Whether a line is the names of columns, and the next one that is no comment a row of them.
bool are_names_of_rows(std::string_view line, std::string_view rest) {
  constexpr std::size_t kMostComments = 32, kEnough = std::size_t{1} << 16U;
  const ColumnNames names = column_names(line.substr(0, kMostHeaderBytes));
  if (!names.position()) return false;
  LineReader lines(rest.substr(0, kEnough));
  for (std::size_t i = 0; i < kMostComments; ++i) {
    const auto next = lines.next();
    if (!next) return false;
    if (!is_blank(next->text) && !text_comment(next->text)) return named_row(names, next->text).has_value();
  }
  return false;
}

}  // namespace

std::optional<std::string_view> text_comment(std::string_view line) {
  line = without_indent(line);
  // A row may begin with a number that is not known, such as #N/A.
  const std::string_view first_cell = line.substr(0, line.find_first_of(",;|\t "));
  const bool is_row = line.starts_with("#") && parse_cell(first_cell, Separator::kSpace).has_value();
  const bool is_comment = !is_row && (line.starts_with('#') || line.starts_with("//"));
  return is_comment ? std::optional(without_mark(line, "#/")) : std::nullopt;
}

std::optional<std::string_view> comment_above_rows(std::string_view line, std::string_view rest) {
  constexpr std::array<std::string_view, 3> kOtherFiles{"%PDF-", "%!PS", "%%MatrixMarket"};
  constexpr std::string_view kMarks = "%!;";
  line = without_indent(line);
  if (line.empty() || kMarks.find(line[0]) == std::string_view::npos) return std::nullopt;
  if (std::ranges::any_of(kOtherFiles, [line](std::string_view begin) { return line.starts_with(begin); })) {
    return std::nullopt;
  }
  if (are_names_of_rows(line, rest)) return std::nullopt;
  return without_mark(line, kMarks);
}

bool is_colmap_header(std::string_view comment) {
  return comment.starts_with("POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[]");
}

}  // namespace segserve::codec
