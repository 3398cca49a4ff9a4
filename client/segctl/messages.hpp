// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace segserve::segctl {

/// Writes "segctl: <message>" to standard error as exactly one line: control characters become spaces. The head of the
/// line is red on a terminal unless NO_COLOR is set.
void print_error(std::string_view message);

/// Like print_error, with a yellow head: the command went on, but not as the user may expect.
void print_warning(std::string_view message);

}  // namespace segserve::segctl
