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

// PCD, the file format of the Point Cloud Library
// (https://pointclouds.org/documentation/tutorials/pcd_file_format.html).
namespace segserve::codec {

/// The values of the header's entry DATA.
enum class PcdEncoding : std::uint8_t { kAscii, kBinary, kBinaryCompressed };

/// Reads a PCD file (of any VERSION; ascii, binary or binary_compressed) from untrusted bytes. The fields may have any
/// order and their names any case. Fields other than these are skipped:
///  - x y z: any type, meters, required. Values that are not finite are kept.
///  - color: `rgb` or `rgba`, SIZE 4, packed as 0xAARRGGBB. With TYPE F, in ascii too, the 32 bits of the float are the
///    packed color; the float's value is never converted. The quiet NaN 0x7fc00000 (in ascii `nan`), which writers use
///    for "no color", is black. Without a packed color, `r g b`, `red green blue`, `diffuse_red ..` or `color_r ..` of
///    any type are the color. Full intensity is 1 for floats that do not exceed it, 65535 for values far above 255, and
///    else 255; other values are clamped, and NaN is 0. `f_dc_0 f_dc_1 f_dc_2` are the spherical harmonics of splats.
///    Without these the cloud has no color; fields that look like color then cause a warning.
///  - label or scalar_Label: any integer type, or floats that are whole numbers. Negative labels and NaN become 0. If
///    one is no 32-bit integer, the cloud has no labels, and a warning says so.
///
/// Text may begin with a byte order mark, end its lines by carriage returns, have comments between its rows, integers
/// beyond their type or with decimals, and NaN as Microsoft spells it. Rows that POINTS does not promise cause a
/// warning.
///
/// The cloud's view is `view` if that is given. Otherwise it is CAMERA if the cloud is organized (HEIGHT above 1) and
/// VIEWPOINT is the identity or absent, else WORLD with the sensor at VIEWPOINT's translation (the origin if absent).
///
/// INVALID_ARGUMENT with a message of one line that names the fault and its place if the file is malformed or
/// truncated, or exceeds the limits. CANCELLED and DEADLINE_EXCEEDED as `stop` says. A file of 0 points is no error
/// here.
absl::StatusOr<LabeledCloud> decode_pcd(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                        std::optional<View> view = std::nullopt, const StopToken& stop = {});

/// Writes PCD 0.7 with the fields x y z, rgb (packed; if the cloud has color) and label (TYPE U, SIZE 4; if `label` is
/// not empty). `label` has one entry per point, or is empty. All three encodings keep floats, colors and labels
/// exactly.
///
/// VIEWPOINT is the position of the sensor; it is the identity for a CAMERA view and for a WORLD view without a sensor.
/// A PCD file therefore cannot tell some views: an organized WORLD cloud with the sensor at the origin or without one,
/// and an unorganized CAMERA cloud, need an explicit view when they are read again.
///
/// A body of 4 GiB or more does not fit into binary_compressed, and is written as binary.
std::string encode_pcd(const CloudView& cloud, std::span<const std::uint32_t> label, PcdEncoding encoding);

}  // namespace segserve::codec
