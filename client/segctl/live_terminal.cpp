// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/live_terminal.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <utility>

namespace segserve::segctl {
namespace {

std::string_view variable(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? std::string_view() : value;
}

/// Whether the locale's characters are UTF-8. The first variable that is set decides.
bool has_unicode() {
  for (const char* name : {"LC_ALL", "LC_CTYPE", "LANG"}) {
    const std::string_view value = variable(name);
    if (value.empty()) continue;
    return value.find("UTF-8") != std::string_view::npos || value.find("utf8") != std::string_view::npos;
  }
  return false;
}

bench_report::LiveStyle style_of_terminal() {
  return {.columns = terminal_columns(), .has_color = variable("NO_COLOR").empty(), .has_unicode = has_unicode()};
}

void write(const std::string& text) {
  std::fputs(text.c_str(), stderr);
  std::fflush(stderr);
}

}  // namespace

bool terminal_moves_cursor() {
  const std::string_view term = variable("TERM");
  return isatty(STDERR_FILENO) == 1 && !term.empty() && term != "dumb";
}

std::size_t terminal_columns() {
  winsize size{};
  const bool is_known = ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return is_known ? size.ws_col : std::size_t{80};
}

LiveTerminal::LiveTerminal(std::string title) {
  if (terminal_moves_cursor()) view_.emplace(std::move(title));
}

LiveTerminal::~LiveTerminal() {
  if (view_) write(view_->wipe());
}

void LiveTerminal::show_progress(double share) {
  const int percent = static_cast<int>(100 * share);
  if (!view_ || percent == shown_percent_) return;
  shown_percent_ = percent;
  view_->set_progress(share);
  redraw();
}

void LiveTerminal::show(const bench_report::LiveSnapshot& snapshot) {
  if (!view_) return;
  view_->add(snapshot);
  redraw();
}

void LiveTerminal::redraw() { write(view_->redraw(style_of_terminal())); }

}  // namespace segserve::segctl
