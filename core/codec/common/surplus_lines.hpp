// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <vector>

#include "segserve/codec/warning.hpp"

namespace segserve::codec {

/// Warns of so many lines of text beyond those that the header of the file promises.
inline void warn_of_surplus_lines(std::uint64_t lines, std::vector<Warning>& warnings) {
  if (lines == 0) return;
  const char* const text = lines == 1 ? "{} line is more than the header promises, and not used"
                                      : "{} lines are more than the header promises, and not used";
  warnings.push_back({WarningReason::kRowsNotUsed, fmt::format(fmt::runtime(text), lines)});
}

}  // namespace segserve::codec
