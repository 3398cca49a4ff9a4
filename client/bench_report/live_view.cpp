// SPDX-License-Identifier: Apache-2.0
#include "client/bench_report/live_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include "client/bench_report/printable.hpp"
#include "fmt/format.h"

namespace segserve::bench_report {
namespace {

constexpr std::size_t kMostIntervals = 300;  ///< that are kept for the sparkline
constexpr std::size_t kLabelColumns = 8;
constexpr std::size_t kBarColumns = 30;

constexpr std::string_view kNormal, kBold = "1", kRed = "31";

/// Part of a line, with the number of an ANSI style.
struct Piece {
  std::string text;
  std::string_view style = kNormal;
};

/// Characters of a UTF-8 text. All that are shown take one column.
std::size_t columns_of(std::string_view text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xc0U) != 0x80U; }));
}

/// The first `columns` characters.
std::string_view cut(std::string_view text, std::size_t columns) {
  std::size_t at = 0;
  for (; at < text.size(); ++at) {
    const bool begins = (static_cast<unsigned char>(text[at]) & 0xc0U) != 0x80U;
    if (begins && columns-- == 0) break;
  }
  return text.substr(0, at);
}

/// Pieces as a line that fits. A piece that does not fit is left out with all behind it; the first one is cut instead.
std::string line_of(const std::vector<Piece>& pieces, const LiveStyle& style) {
  std::string line;
  std::size_t left = style.columns > 0 ? style.columns - 1 : 0;  // The last column makes some terminals break the line.
  for (const Piece& piece : pieces) {
    const bool is_first = line.empty();
    if (columns_of(piece.text) > left && !is_first) break;
    const std::string_view text = cut(piece.text, left);
    left -= columns_of(text);
    if (style.has_color && !piece.style.empty()) {
      line += fmt::format("\033[{}m{}\033[0m", piece.style, text);
    } else {
      line += text;
    }
  }
  return line + "\n";
}

Piece label(std::string_view text) { return {fmt::format("{:<{}}", text, kLabelColumns), kBold}; }

std::string milliseconds(std::optional<double> ms) {
  if (!ms) return "-";
  return std::isinf(*ms) ? "infinite" : fmt::format("{:.{}f}", *ms, *ms < 100 ? 1 : 0);
}

Piece percentiles(std::optional<double> p50, std::optional<double> p99) {
  return {fmt::format("  p50 {:>6}  p99 {:>6} ms", milliseconds(p50), milliseconds(p99))};
}

Piece failures(double failed, double results) {
  if (failed == 0) return {"  0 failed"};
  return {fmt::format("  {:.0f} failed ({:.2g} %)", failed, 100 * failed / (failed + results)), kRed};
}

/// The last values as bars between 0 and the largest one. Where there is no value it has a space, and an infinite one
/// is the highest.
std::string sparkline(const std::deque<std::optional<double>>& values, std::size_t columns, bool has_unicode) {
  static constexpr std::array<std::string_view, 8> kBars{"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
  static constexpr std::array<std::string_view, 8> kLetters{"_", ".", ":", "-", "=", "+", "*", "#"};
  const std::size_t count = std::min(columns, values.size());
  const auto first = values.end() - static_cast<std::ptrdiff_t>(count);
  double highest = 0;
  for (auto value = first; value != values.end(); ++value) {
    if (*value && std::isfinite(**value)) highest = std::max(highest, **value);
  }
  std::string text;
  for (auto value = first; value != values.end(); ++value) {
    if (!*value) {
      text += ' ';
      continue;
    }
    const double share = std::isinf(**value) ? 1 : highest > 0 ? **value / highest : 0;
    const auto level = static_cast<std::size_t>(std::clamp(std::ceil(8 * share) - 1, 0.0, 7.0));
    text += (has_unicode ? kBars : kLetters)[level];
  }
  return text;
}

/// The smallest and the largest of the finite values: "29.1 to 112 ms".
std::string range_text(const std::deque<std::optional<double>>& values, std::size_t columns) {
  double low = INFINITY, high = 0;
  const auto first = values.end() - static_cast<std::ptrdiff_t>(std::min(columns, values.size()));
  for (auto value = first; value != values.end(); ++value) {
    if (!*value || std::isinf(**value)) continue;
    low = std::min(low, **value);
    high = std::max(high, **value);
  }
  return std::isinf(low) ? "" : fmt::format(" {} to {} ms", milliseconds(low), milliseconds(high));
}

}  // namespace

void LiveView::add(const LiveSnapshot& snapshot) {
  last_ = snapshot;
  p99_.push_back(snapshot.p99_ms);
  if (p99_.size() > kMostIntervals) p99_.pop_front();
}

std::string LiveView::lines(const LiveStyle& style) const {
  const auto filled = static_cast<std::size_t>(std::clamp(share_, 0.0, 1.0) * kBarColumns);
  const bool warms_up = last_ && last_->t < 0;
  std::string text = line_of({label("bench"),
                              {fmt::format("{:3.0f} %", 100 * std::clamp(share_, 0.0, 1.0))},
                              {fmt::format(" [{:-<{}}]", std::string(filled, '#'), kBarColumns)},
                              {warms_up ? " warm-up" : ""},
                              {"  " + printable(title_)}},
                             style);
  if (!last_) return text;
  const LiveSnapshot& now = *last_;
  const double seconds = now.seconds > 0 ? now.seconds : 1;
  const std::string offered = now.offered > 0 ? fmt::format(" of {:.1f}", now.offered / seconds) : "";
  text += line_of({label("now"),
                   {fmt::format("{:<24}", fmt::format("{:.1f}{} frames/s", now.results / seconds, offered))},
                   percentiles(now.p50_ms, now.p99_ms),
                   failures(now.failed, now.results)},
                  style);
  if (!warms_up) {
    text += line_of({label("so far"),
                     {fmt::format("{:<24}", fmt::format("{} results", now.all_results))},
                     percentiles(now.all_p50_ms, now.all_p99_ms),
                     failures(static_cast<double>(now.all_failed), static_cast<double>(now.all_results))},
                    style);
  }
  constexpr std::size_t kRangeColumns = 24;
  const std::size_t room =
      style.columns > kLabelColumns + kRangeColumns + 10 ? style.columns - kLabelColumns - kRangeColumns : 10;
  text += line_of({label("p99"), {sparkline(p99_, room, style.has_unicode)}, {range_text(p99_, room)}}, style);
  return text;
}

std::string LiveView::redraw(const LiveStyle& style) {
  std::string text = wipe();
  const std::string drawn = lines(style);
  drawn_lines_ = static_cast<std::size_t>(std::ranges::count(drawn, '\n'));
  return text + drawn;
}

std::string LiveView::wipe() {
  if (drawn_lines_ == 0) return "";
  return fmt::format("\033[{}A\r\033[J", std::exchange(drawn_lines_, 0));
}

}  // namespace segserve::bench_report
