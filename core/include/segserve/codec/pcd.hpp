// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/codec/labeled_cloud.hpp"
#include "segserve/stop_token.hpp"

namespace segserve::codec {

enum class PcdEncoding : std::uint8_t { kAscii, kBinary, kBinaryCompressed };

/// Reads a PCD file (0.5 to 0.7; ascii, binary or binary_compressed) from untrusted bytes.
///
/// Fields, in any order; others are skipped:
///  - x y z: F4 or F8, required. Values that are not finite are kept.
///  - color: `rgb` or `rgba`, 4 bytes packed as 0xAARRGGBB. A float there is the same 32 bits
///    under another type, in ascii too, and never a number to convert; exactly the quiet NaN
///    0x7fc00000 (the text `nan`), which writers use for "no color", is black. Or `r`, `g` and `b`, each any
///    integer or float, 0 to 255: others are clamped, NaN is 0. With none of them the cloud has no color.
///  - label: any integer, or floats that are integers. Negative ones and NaN become 0.
///
/// View: `view` if given; else CAMERA if the cloud is organized (HEIGHT > 1) and VIEWPOINT is the
/// identity or absent; else WORLD with the sensor at VIEWPOINT's translation (the origin if absent).
///
/// INVALID_ARGUMENT with one line that names the fault and its place for anything else, a header
/// that promises more than there is, and exceeded limits. A cloud of 0 points is not a fault here.
absl::StatusOr<LabelledCloud> decode_pcd(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                         std::optional<View> view = std::nullopt, const StopToken& stop = {});

/// Writes PCD 0.7 with the fields x y z, rgb (packed; if the cloud has color) and label (U4; if
/// `label`, which has an entry per point, is not empty). Floats and colors survive exactly in all
/// three encodings. VIEWPOINT is the sensor's position, the identity for CAMERA or no sensor:
/// an organized WORLD cloud with the sensor at the origin or unknown, and an unorganized CAMERA
/// cloud, therefore need an explicit view when they are read again.
/// A body of 4 GiB or more does not fit into binary_compressed and is written as binary.
std::string encode_pcd(const CloudView& cloud, std::span<const std::uint32_t> label, PcdEncoding encoding);

}  // namespace segserve::codec
