// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "CLI/CLI.hpp"

namespace segserve {

/// For options that are stored as unsigned integers: CLI11 would turn -1 into the largest one.
inline CLI::Validator not_negative() {
  return {[](const std::string& text) {
            return text.starts_with('-') ? text + " is negative, but must be a whole number of at least 0" : "";
          },
          ""};
}

}  // namespace segserve
