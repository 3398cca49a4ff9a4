// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/codec/las/las_header.hpp"

namespace segserve::codec {

/// Reads the variable length records that matter: the description of extra bytes, and the view that segserve writes.
/// `space` is what lies between the header and the points. Damaged records are not used, with a warning.
void read_las_records(std::span<const std::byte> space, std::uint32_t count, LasHeader& header);

}  // namespace segserve::codec
