// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/stream_terminal.hpp"

#include <algorithm>
#include <cstdio>

#include "client/segctl/live_terminal.hpp"
#include "fmt/format.h"

namespace segserve::segctl {

StreamTerminal::StreamTerminal() : is_shown_(terminal_moves_cursor()) {}

StreamTerminal::~StreamTerminal() { wipe(); }

std::size_t StreamTerminal::columns() const { return terminal_columns(); }

void StreamTerminal::wipe() {
  if (drawn_lines_ > 0) fmt::print(stderr, "\x1b[{}A\x1b[J", drawn_lines_);
  drawn_lines_ = 0;
  std::fflush(stderr);
}

void StreamTerminal::show(const std::string& lines) {
  if (!is_shown_) return;
  wipe();
  std::fputs(lines.c_str(), stderr);
  std::fflush(stderr);
  drawn_lines_ = static_cast<std::size_t>(std::ranges::count(lines, '\n'));
}

}  // namespace segserve::segctl
