// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/stop_token.hpp"

namespace segserve::codec {

/// The planes of a cloud of N points as bytes that somebody else owns.
struct PlanarBytes {
  std::string_view x, y, z;  ///< meters, float32 little-endian: 4N bytes each
  std::string_view rgb;      ///< R, G, B interleaved: 3N bytes; empty: no color
};

/// The same, owned.
struct PlanarPlanes {
  std::string x, y, z, rgb;

  operator PlanarBytes() const { return {x, y, z, rgb}; }  // NOLINT(google-explicit-constructor)
};

/// N = width * height points. Coordinates stay where they are if they are aligned there as floats are, so `planes` must
/// outlive the cloud. INVALID_ARGUMENT naming the plane whose length does not fit, or the
/// limit that is exceeded; that of `stop` once it says so. Neither coordinates nor an empty cloud are judged here.
absl::StatusOr<BorrowingCloud> decode_planar(const PlanarBytes& planes, std::uint32_t width, std::uint32_t height,
                                             const View& view, const DecodeLimits& limits, const StopToken& stop = {});

PlanarPlanes encode_planar(const CloudView& cloud);

/// The same without a copy of the coordinates: valid as long as the cloud's planes, and `rgb`, which becomes the
/// colors' bytes.
PlanarBytes encode_planar_in_place(const CloudView& cloud, std::unique_ptr<char[]>& rgb);

}  // namespace segserve::codec
