// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "absl/status/statusor.h"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/codec/labeled_cloud.hpp"
#include "segserve/codec/read_options.hpp"
#include "segserve/stop_token.hpp"

// Sweeps of a LiDAR as KITTI, SemanticKITTI and nuScenes have them (`.bin`): nothing but floats of 32 bits, little
// endian. KITTI has four for each point, x y z intensity, and nuScenes five, x y z intensity ring. Positions are meters
// in the frame of the sensor.
namespace segserve::codec {

/// Whether a file is such a sweep, judged by its size in bytes and the values of its first points, because it has no
/// header: their positions are finite and within 1 km, their intensity is from 0 to 1 or a whole number up to 255, and
/// their ring a small whole number, but for one point in a hundred. `begin` may be the whole file. A file of fewer than
/// 16 points is none.
bool is_lidar_scan(std::string_view begin, std::uint64_t file_bytes);

/// Decodes such a file. Its view is WORLD with the sensor at the origin. INVALID_ARGUMENT if it is none, or
/// beyond the limits; CANCELLED, DEADLINE_EXCEEDED.
absl::StatusOr<LabeledCloud> decode_lidar_scan(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                               const ReadOptions& options = {}, const StopToken& stop = {});

}  // namespace segserve::codec
