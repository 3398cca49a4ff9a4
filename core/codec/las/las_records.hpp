// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/stop_check.hpp"
#include "core/codec/las/las_header.hpp"

namespace segserve::codec {

/// The two kinds of variable length records: in front of the points, and extended ones behind them.
enum class LasRecordKind : std::uint8_t { kShort, kExtended };

/// Reads the variable length records that matter: the description of extra bytes, the reference system, and what
/// segserve states. `space` is where the `count` records lie. Records that are not whole are not used, with a warning.
void read_las_records(std::span<const std::byte> space, LasRecordKind kind, std::uint32_t count, StopCheck& check,
                      LasHeader& header);

}  // namespace segserve::codec
