// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
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

/// Warns of bytes behind those that the header of a binary file promises, if they are as many as a row has. Zeros are
/// what fills up a block, and no rows.
inline void warn_of_surplus_bytes(std::span<const std::byte> bytes, std::size_t row_bytes,
                                  std::vector<Warning>& warnings) {
  const auto is_zero = [](std::byte byte) { return byte == std::byte{0}; };
  if (row_bytes == 0 || bytes.size() < row_bytes || std::ranges::all_of(bytes, is_zero)) return;
  warnings.push_back({WarningReason::kRowsNotUsed,
                      fmt::format("{} bytes, which are {} rows, are more than the header promises, and not used",
                                  bytes.size(), bytes.size() / row_bytes)});
}

}  // namespace segserve::codec
