// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/codec/labeled_cloud.hpp"
#include "segserve/codec/read_options.hpp"
#include "segserve/stop_token.hpp"

// PCD, the file format of the Point Cloud Library
// (https://pointclouds.org/documentation/tutorials/pcd_file_format.html).
namespace segserve::codec {

/// The values of the header's entry DATA.
enum class PcdEncoding : std::uint8_t { kAscii, kBinary, kBinaryCompressed };

/// Reads a PCD file (of any VERSION; ascii, binary or binary_compressed) from untrusted bytes. The fields may have any
/// order and their names any case. Fields other than these are skipped:
///  - x y z: any type, required. Values that are not finite are kept. Coordinates far from 0 are moved: see Placement.
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
/// The cloud's view is that of the options, else that of a comment that encode_pcd wrote, else what the points and
/// VIEWPOINT make plain; LabeledCloud::view_rule says what was chosen, and why. In short: an organized cloud whose
/// points lie on the rays of pixels is CAMERA, and so is an unorganized one whose points do; the sweep of a LiDAR is
/// WORLD with the sensor at the origin; else a VIEWPOINT that is not (0, 0, 0) is the sensor of a WORLD cloud. A
/// default VIEWPOINT is the sensor only if it is outside the points, and not below them.
///
/// INVALID_ARGUMENT with a message of one line that names the fault and its place if the file is malformed or
/// truncated, or exceeds the limits. CANCELLED and DEADLINE_EXCEEDED as `stop` says. A file of 0 points is no error
/// here.
absl::StatusOr<LabeledCloud> decode_pcd(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                        const ReadOptions& options = {}, const StopToken& stop = {});

/// Writes PCD 0.7 with the fields x y z, rgb (packed; if the cloud has color), the attributes, and label (TYPE U, SIZE
/// 4; if there are labels). Coordinates are floats, or doubles if the content has a position in the file. All three
/// encodings keep numbers, colors and labels exactly. An attribute whose name would be taken for a coordinate, color or
/// label gets `input_` in front of it.
///
/// VIEWPOINT is the position of the sensor; it is the identity for a CAMERA view and for a WORLD view without a sensor.
/// A comment tells the view in full, so that decode_pcd finds the same. Another one tells the unit of the coordinates
/// unless it is the meter.
///
/// A body of 4 GiB or more does not fit into binary_compressed, and is written as binary.
std::string encode_pcd(const FileContent& content, PcdEncoding encoding);
/// Does the same for a cloud and its labels: one entry per point, or none.
std::string encode_pcd(const CloudView& cloud, std::span<const std::uint32_t> label, PcdEncoding encoding);

}  // namespace segserve::codec
