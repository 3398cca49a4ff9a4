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

// The layout of v1.PlanarCloud (proto/segserve/v1/cloud.proto): one plane of numbers per channel.
namespace segserve::codec {

/// The planes of a cloud of N points, as bytes in memory of somebody else.
struct PlanarBytes {
  std::string_view x, y, z;  ///< 4N bytes each: little-endian float32, meters
  std::string_view rgb;      ///< 3N bytes: R, G, B of each point; empty if the cloud has no color
};

/// The planes of a cloud that own their bytes (see PlanarBytes for their meaning).
struct PlanarPlanes {
  std::string x, y, z, rgb;

  operator PlanarBytes() const { return {x, y, z, rgb}; }  // NOLINT(google-explicit-constructor)
};

/// Decodes a cloud of width * height points. Coordinates are in the frame of `view`, which becomes the view of the
/// cloud. The cloud borrows each coordinate plane that is aligned as floats must be, and copies the others, so the
/// bytes of `planes` must outlive it. INVALID_ARGUMENT that names the plane whose length does not fit, or the exceeded
/// limit. CANCELLED and DEADLINE_EXCEEDED as `stop` says. Coordinates are not checked, and an empty cloud is no error.
absl::StatusOr<BorrowingCloud> decode_planar(const PlanarBytes& planes, std::uint32_t width, std::uint32_t height,
                                             const View& view, const DecodeLimits& limits, const StopToken& stop = {});

/// Copies a cloud into planes. The shape and the view of the cloud are not part of them.
PlanarPlanes encode_planar(const CloudView& cloud);

/// Encodes a cloud as encode_planar does, without a copy of the coordinates. The bytes of the colors are written to
/// `rgb`, which is allocated. The result is valid as long as the planes of the cloud and `rgb` are.
PlanarBytes encode_planar_in_place(const CloudView& cloud, std::unique_ptr<char[]>& rgb);

}  // namespace segserve::codec
