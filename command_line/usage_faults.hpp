// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>

#include "CLI/CLI.hpp"

namespace segserve {

/// Puts into our words what CLI11 says of the values of an option, without the name of the option: "'many' is no whole
/// number".
std::string fault_of_values(const CLI::Option& option, const CLI::ParseError& error);

/// Everything that is wrong with the command line that `app` has refused with `error`, in one line: an unknown command
/// or unknown options, with the names that may have been meant; values that are no numbers or out of range; options
/// that are missing or do not go together. CLI11 itself tells the first of them only. The line ends with the command
/// that shows the help, and has no line feed.
std::string usage_faults(CLI::App& app, const CLI::ParseError& error);

/// Names the options of the command that were given with an empty value, as "--view-from is empty", in one line; empty
/// if there is none. Scripts do so by a variable that is not set, and to most options an empty text is none at all.
/// An empty text is a value of the options in `except`.
std::string empty_values(const CLI::App& app, std::initializer_list<std::string_view> except = {});

}  // namespace segserve
