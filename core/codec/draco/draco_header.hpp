// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

#include "absl/status/statusor.h"

namespace segserve::codec {

/// What a Draco file says before its data.
struct DracoHeader {
  std::uint32_t points = 0;
  unsigned color_components = 0;  ///< 0: no color
};

/// Draco's decoder allocates whatever a file claims, so this reads the claims first. INVALID_ARGUMENT unless the file
/// is a point cloud of bitstream 2.3, sequentially encoded, without metadata, with POSITION (3 floats) and at most
/// COLOR (3 or 4 unsigned bytes) besides.
absl::StatusOr<DracoHeader> read_draco_header(std::string_view bytes);

}  // namespace segserve::codec
