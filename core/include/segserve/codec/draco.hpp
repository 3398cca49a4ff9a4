// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/stop_token.hpp"

// Clouds in Google's Draco format, bitstream 2.3 (https://google.github.io/draco/spec). Points are encoded
// sequentially, which keeps their order. Draco stores finite points only, so a bitmap beside it tells which points are
// finite.
namespace segserve::codec {

/// Whether this build has Draco (CMake option SEGSERVE_WITH_DRACO). Without it encode_draco and decode_draco return
/// UNIMPLEMENTED.
bool draco_is_built();

/// A cloud of N points as Draco's bytes and a bitmap.
struct DracoFile {
  /// The finite points in their order: POSITION as 3 floats, meters, and COLOR as 3 unsigned bytes if the cloud has
  /// color. Empty if no point is finite.
  std::string data;
  /// One bit per point, ceil(N / 8) bytes: bit i % 8 (0 is the lowest) of byte i / 8 is 1 if point i is finite. Empty
  /// if all points are finite.
  std::string finite;
};

/// Encodes a cloud. The decoded cloud has every coordinate of a finite point within `error_bound` meters and its color
/// exactly; points that are not finite are NaN and black. INVALID_ARGUMENT if the bound is not above 0, or if the 30
/// bits that Draco has at most cannot keep it. INTERNAL if Draco fails.
absl::StatusOr<DracoFile> encode_draco(const CloudView& cloud, double error_bound);

/// Decodes a cloud of width * height points from DracoFile::data and DracoFile::finite. Coordinates are in the frame of
/// `view`, which becomes the view of the cloud. FAILED_PRECONDITION unless `limits.draco` is set. INVALID_ARGUMENT that
/// names the fault or the exceeded limit: Draco does not see meshes, files that reorder points (kd-tree), attributes
/// other than position and color, or counts that do not fit the cloud. CANCELLED and DEADLINE_EXCEEDED as `stop` says.
absl::StatusOr<Cloud> decode_draco(std::string_view data, std::string_view finite, std::uint32_t width,
                                   std::uint32_t height, const View& view, const DecodeLimits& limits,
                                   const StopToken& stop = {});

}  // namespace segserve::codec
