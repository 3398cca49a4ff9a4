// SPDX-License-Identifier: Apache-2.0
#include "core/lab/eval/report_page.hpp"
#include "core/lab/eval/report_tables.hpp"
#include "fmt/format.h"

namespace segserve::eval {
namespace {

bool is_control(char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; }

/// Everything that Markdown, or the HTML within it, could take for markup in the middle of a line is escaped. Line
/// feeds would end a row.
std::string escape_markdown(std::string_view text) {
  constexpr std::string_view kMarkup = "\\`*_[]<>|&~$";
  std::string escaped;
  for (const char c : text) {
    if (kMarkup.find(c) != std::string_view::npos) escaped += '\\';
    escaped += is_control(c) ? ' ' : c;
  }
  return escaped;
}

/// A path as the destination of a link: all but unreserved characters and slashes become %XX.
std::string link_to(std::string_view path) {
  constexpr std::string_view kUnreserved = "-_.~/";
  std::string link;
  for (const char c : path) {
    const bool is_plain = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                          kUnreserved.find(c) != std::string_view::npos;
    link += is_plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return link;
}

std::string markdown_row(const std::vector<std::string>& cells) {
  std::string row = "|";
  for (const std::string& text : cells) row += fmt::format(" {} |", escape_markdown(text));
  return row + "\n";
}

std::string markdown_table(const ReportTable& table) {
  std::string text = fmt::format("\n## {}\n\n{}| --- |", table.title, markdown_row(table.columns));
  for (std::size_t i = 1; i < table.columns.size(); ++i) text += " ---: |";
  text += "\n";
  for (const auto& row : table.rows) text += markdown_row(row);
  return text;
}

}  // namespace

std::string picture_name(std::string_view which, std::size_t number) {
  return fmt::format("{}-{}.png", which, number + 1);
}

std::string to_markdown(const Report& report, const Peer* peer, std::span<const Thumbnails> worst,
                        const std::string& folder) {
  std::string text =
      fmt::format("# Scores of {}\n\n{}\n", escape_markdown(report.method), escape_markdown(headline(report)));
  const std::vector<ReportTable> tables = tables_of(report, peer);
  text += markdown_table(tables.front());
  if (!worst.empty()) text += "\n## Worst scenes by the WOv of their objects\n\n| scene | ground truth | segments |\n";
  if (!worst.empty()) text += "| --- | --- | --- |\n";
  for (std::size_t i = 0; i < worst.size(); ++i) {
    text += fmt::format("| {} |", escape_markdown(worst[i].file));
    for (const std::string_view which : {"truth", "segments"}) {
      text += folder.empty() ? " - |" : fmt::format(" ![{}]({}/{}) |", which, link_to(folder), picture_name(which, i));
    }
    text += "\n";
  }
  for (const ReportTable& table : std::span(tables).subspan(1)) text += markdown_table(table);
  return text;
}

}  // namespace segserve::eval
