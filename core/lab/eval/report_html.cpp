// SPDX-License-Identifier: Apache-2.0
#include "absl/strings/escaping.h"
#include "core/lab/eval/report_page.hpp"
#include "core/lab/eval/report_tables.hpp"
#include "fmt/format.h"

namespace segserve::eval {
namespace {

constexpr std::string_view kStyle = R"(
body { font: 14px/1.4 system-ui, sans-serif; margin: 2em; color: #222; background: #fff; }
table { border-collapse: collapse; }
th, td { padding: 2px 10px; border-bottom: 1px solid #ddd; text-align: right; font-variant-numeric: tabular-nums; }
th:first-child, td:first-child { text-align: left; }
figure { display: inline-block; margin: 0 1em 1em 0; }
img { display: block; max-width: 100%; }
)";

std::string escape_html(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string html_row(const std::vector<std::string>& cells, std::string_view tag) {
  std::string row = "<tr>";
  for (const std::string& text : cells) row += fmt::format("<{0}>{1}</{0}>", tag, escape_html(text));
  return row + "</tr>\n";
}

std::string html_table(const ReportTable& table) {
  std::string html = fmt::format("<h2>{}</h2>\n<table>\n", escape_html(table.title));
  html += fmt::format("<thead>{}</thead>\n<tbody>\n", html_row(table.columns, "th"));
  for (const auto& row : table.rows) html += html_row(row, "td");
  return html + "</tbody>\n</table>\n";
}

std::string html_figure(std::string_view caption, const std::string& png) {
  return fmt::format(
      "<figure><img alt=\"{0}\" src=\"data:image/png;base64,{1}\"><figcaption>{0}</figcaption></figure>\n", caption,
      absl::Base64Escape(png));
}

}  // namespace

std::string to_html(const Report& report, const Peer* peer, std::span<const Thumbnails> worst) {
  std::string html = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
  html += fmt::format("<title>Scores of {}</title>\n<style>{}</style>\n</head>\n<body>\n", escape_html(report.method),
                      kStyle);
  html += fmt::format("<h1>Scores of {}</h1>\n<p>{}</p>\n", escape_html(report.method), escape_html(headline(report)));
  const std::vector<ReportTable> tables = tables_of(report, peer);
  html += html_table(tables.front());
  if (!worst.empty()) html += "<h2>Worst scenes by the WOv of their objects</h2>\n";
  for (const Thumbnails& scene : worst) {
    html += fmt::format("<h3>{}</h3>\n", escape_html(scene.file)) + html_figure("ground truth", scene.truth) +
            html_figure("segments", scene.segments);
  }
  for (const ReportTable& table : std::span(tables).subspan(1)) html += html_table(table);
  return html + "</body>\n</html>\n";
}

}  // namespace segserve::eval
