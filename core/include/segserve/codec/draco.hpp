// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/stop_token.hpp"

// Google's Draco, sequentially encoded, which keeps the order of the points. Optional: see draco_is_built.
namespace segserve::codec {

/// Whether this build has Draco (CMake: SEGSERVE_WITH_DRACO). Without it the functions below are UNIMPLEMENTED.
bool draco_is_built();

struct DracoFile {
  std::string data;    ///< the finite points: POSITION, 3 floats; COLOR, 3 unsigned bytes. Empty if there is none
  std::string finite;  ///< a bit per point of the cloud, the first lowest: 1 if it is finite; empty: all are
};

/// Every coordinate of a finite point within `error_bound` meters, colors exactly; points that are not finite come
/// back as NaN, black. INVALID_ARGUMENT unless the bound is above 0 and Draco's at most 30 bits can keep it.
absl::StatusOr<DracoFile> encode_draco(const CloudView& cloud, double error_bound);

/// The cloud of width * height points. INVALID_ARGUMENT that names the fault or the limit; files that reorder points
/// (kd-tree), meshes, other attributes and counts that do not fit are refused before Draco sees them.
/// FAILED_PRECONDITION unless `limits.draco`.
absl::StatusOr<Cloud> decode_draco(std::string_view data, std::string_view finite, std::uint32_t width,
                                   std::uint32_t height, const View& view, const DecodeLimits& limits,
                                   const StopToken& stop = {});

}  // namespace segserve::codec
