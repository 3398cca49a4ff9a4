// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/stop_check.hpp"
#include "segserve/codec/decode_limits.hpp"

namespace segserve::codec {

/// A file in a zip archive.
struct ZipMember {
  std::string name;
  std::uint16_t method = 0;  ///< 0: stored, 8: deflated
  std::size_t compressed_bytes = 0, bytes = 0;
  std::size_t header_offset = 0;  ///< of its local header
};

/// Lists the members of a zip archive (PKWARE's APPNOTE.TXT) by its central directory. INVALID_ARGUMENT if it is
/// damaged, encrypted or larger than 4 GiB, if it has more than 4096 members, or if the members are together larger
/// than the limits.
absl::StatusOr<std::vector<ZipMember>> list_zip(std::span<const std::byte> archive, const DecodeLimits& limits);

/// The content of a member. INVALID_ARGUMENT if it is damaged or compressed in another way; CANCELLED,
/// DEADLINE_EXCEEDED.
absl::StatusOr<std::vector<std::byte>> read_zip_member(std::span<const std::byte> archive, const ZipMember& member,
                                                       StopCheck& check);

}  // namespace segserve::codec
