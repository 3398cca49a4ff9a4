// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace segserve {

/// Two adjacent regions; a < b.
struct RegionEdge {
  std::uint32_t a = 0, b = 0;
  bool operator==(const RegionEdge&) const = default;
};

}  // namespace segserve
