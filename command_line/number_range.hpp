// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "CLI/CLI.hpp"
#include "fmt/format.h"

namespace segserve {

/// For options that take a number from `least` to `most`. CLI::Range lets "nan" through. The words are CLI11's, which
/// fault_of_values makes a sentence.
inline CLI::Validator number_range(double least, double most) {
  return {[least, most](const std::string& text) -> std::string {
            double value = 0;
            if (!CLI::detail::lexical_cast(text, value)) return "";  // the conversion tells
            if (value >= least && value <= most) return "";
            return fmt::format("{} not in [{} - {}]", text, least, most);
          },
          ""};
}

/// As number_range, for a time in seconds, of which "5s" and "500ms" are none.
inline CLI::Validator seconds_range(double least, double most) {
  return {[least, most](const std::string& text) -> std::string {
            double value = 0;
            const bool is_number = CLI::detail::lexical_cast(text, value);
            if (!is_number) return fmt::format("'{}' is no number of seconds, which has no unit, such as 0.5", text);
            if (value >= least && value <= most) return "";
            return fmt::format("{} not in [{} - {}] seconds", text, least, most);
          },
          ""};
}

}  // namespace segserve
