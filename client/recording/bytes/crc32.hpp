// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

namespace segserve::recording {

/// The CRC-32 of zlib and PNG over the bytes so far (0 at the beginning) and these.
std::uint32_t crc32(std::uint32_t so_far, std::string_view bytes);

}  // namespace segserve::recording
