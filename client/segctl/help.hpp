// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "CLI/CLI.hpp"

namespace segserve::segctl {

/// The texts in the help of a command, beside the descriptions of its options.
struct HelpText {
  std::vector<std::string> common;  ///< The options that --help lists, e.g. "--method"; --help-all lists every option.
  std::string examples;             ///< Command lines, one a line, without indentation.
  std::string details;              ///< Paragraphs that only --help-all shows. May be empty.
  std::string exit_codes;           ///< The meaning of each exit code, "0 success; 1 ...".
};

/// Gives a command the flags --help (short, with examples) and --help-all (everything). Call it after all options were
/// added.
void set_help(CLI::App& command, HelpText text);

}  // namespace segserve::segctl
