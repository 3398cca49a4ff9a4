// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

#include "absl/status/statusor.h"

namespace segserve::codec {

/// The claims of a Draco file before its data.
struct DracoHeader {
  std::uint32_t points = 0;
  unsigned color_components = 0;  ///< 0 if it has no color
};

/// Reads the claims of a file, because Draco's decoder allocates whatever a file claims. INVALID_ARGUMENT unless the
/// file is a point cloud of bitstream 2.3 that is sequentially encoded, has no metadata, and has the attributes
/// POSITION (3 floats) and at most COLOR (3 or 4 unsigned bytes).
absl::StatusOr<DracoHeader> read_draco_header(std::string_view bytes);

}  // namespace segserve::codec
