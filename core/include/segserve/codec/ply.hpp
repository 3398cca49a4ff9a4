// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/codec/labeled_cloud.hpp"

// PLY 1.0, Stanford's polygon file format (https://paulbourke.net/dataformats/ply/).
namespace segserve::codec {

/// The formats that encode_ply writes.
enum class PlyEncoding : std::uint8_t { kAscii, kBinaryLittleEndian };

/// Whether the first line of the file is PLY's magic word, "ply".
bool is_ply(std::string_view file);

/// Reads the element `vertex` of a PLY file (ascii, or binary of either byte order) from untrusted bytes. The
/// properties may have any order. Other elements and properties, lists included, are skipped. Coordinates, colors,
/// labels and text are those of decode_pcd. What follows the vertices is only looked at: if it is damaged, missing or
/// more than the header promises, a warning says so.
///
/// The cloud is unorganized. PLY does not tell where the sensor is, so the view is WORLD without a sensor unless `view`
/// is given.
///
/// INVALID_ARGUMENT with a message of one line that names the fault and its place if the file is malformed or
/// truncated, has more vertices than 32 bits can count, or exceeds the limits. A file of 0 points is no error here.
absl::StatusOr<LabeledCloud> decode_ply(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                        std::optional<View> view = std::nullopt);

/// Writes a PLY file whose vertices have x y z (float), red green blue (uchar; if the cloud has color) and label (uint;
/// if `label` is not empty). `label` has one entry per point, or is empty. Both encodings keep floats, colors and
/// labels exactly. The rows and columns of an organized cloud, and the view, are lost.
std::string encode_ply(const CloudView& cloud, std::span<const std::uint32_t> label, PlyEncoding encoding);

}  // namespace segserve::codec
