// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/messages.hpp"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string>

namespace segserve::segctl {
namespace {

/// The message as one line, so that a hostile file name cannot start a new line or control the terminal.
std::string as_one_line(std::string_view message) {
  std::string line;
  for (const char c : message) {
    const bool is_control = static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
    if (!is_control) {
      line += c;
    } else if (!line.empty() && line.back() != ' ') {
      line += ' ';
    }
  }
  while (!line.empty() && line.back() == ' ') line.pop_back();
  return line;
}

void print(std::string_view message, const char* colored_head) {
  const bool color = isatty(STDERR_FILENO) == 1 && std::getenv("NO_COLOR") == nullptr;
  std::fprintf(stderr, "%s %s\n", color ? colored_head : "segctl:", as_one_line(message).c_str());
}

}  // namespace

void print_error(std::string_view message) { print(message, "\033[1;31msegctl:\033[0m"); }

void print_warning(std::string_view message) { print(message, "\033[1;33msegctl:\033[0m"); }

}  // namespace segserve::segctl
