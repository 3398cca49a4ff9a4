#include "client/segctl/exit_code.hpp"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string>

namespace segserve::segctl {

ExitCode exit_code(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kOk:
      return kSuccess;
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kOutOfRange:
    case absl::StatusCode::kNotFound:
      return kBadInput;
    default:
      return kFailed;
  }
}

namespace {

void print(std::string_view message, const char* colored_head) {
  std::string line;
  for (const char c : message) {
    const bool control = static_cast<unsigned char>(c) < 0x20 || c == 0x7f;  // a hostile file's name stays one line
    if (!control) {
      line += c;
    } else if (!line.empty() && line.back() != ' ') {
      line += ' ';
    }
  }
  while (!line.empty() && line.back() == ' ') line.pop_back();
  const bool color = isatty(STDERR_FILENO) == 1 && std::getenv("NO_COLOR") == nullptr;
  std::fprintf(stderr, "%s %s\n", color ? colored_head : "segctl:", line.c_str());
}

}  // namespace

void print_error(std::string_view message) { print(message, "\033[1;31msegctl:\033[0m"); }

void print_warning(std::string_view message) { print(message, "\033[1;33msegctl:\033[0m"); }

}  // namespace segserve::segctl
