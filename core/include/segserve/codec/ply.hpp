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

namespace segserve::codec {

enum class PlyEncoding : std::uint8_t { kAscii, kBinaryLittleEndian };

/// True if the first line of the file is PLY's magic word.
bool is_ply(std::string_view file);

/// Reads the `vertex` element of a PLY 1.0 file (ascii, binary of either byte order) from
/// untrusted bytes; other elements and properties, lists too, are skipped.
///
/// Properties: x y z, float or double, required; color `red green blue` or
/// `diffuse_red diffuse_green diffuse_blue`, integers 0 to 255; label `label` or `scalar_Label`,
/// read as in a PCD file. The cloud is unorganized; PLY knows no sensor, so the view is WORLD
/// without one unless `view` is given.
///
/// INVALID_ARGUMENT with one line that names the fault and its place for anything else, a header
/// that promises more than there is, and exceeded limits.
absl::StatusOr<LabelledCloud> decode_ply(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                         std::optional<View> view = std::nullopt);

/// Writes the vertices x y z (float), red green blue (uchar; if the cloud has color) and label
/// (uint; if `label`, which has an entry per point, is not empty). Floats survive exactly in both
/// encodings; rows and columns of an organized cloud, and the view, do not.
std::string encode_ply(const CloudView& cloud, std::span<const std::uint32_t> label, PlyEncoding encoding);

}  // namespace segserve::codec
