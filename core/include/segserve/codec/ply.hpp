// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/codec/labeled_cloud.hpp"
#include "segserve/codec/read_options.hpp"
#include "segserve/codec/warning.hpp"
#include "segserve/stop_token.hpp"

// PLY 1.0, Stanford's polygon file format (https://paulbourke.net/dataformats/ply/).
namespace segserve::codec {

/// The formats that encode_ply writes.
enum class PlyEncoding : std::uint8_t { kAscii, kBinaryLittleEndian };

/// Whether the first line of the file is PLY's magic word, "ply".
bool is_ply(std::string_view file);

/// Reads the element `vertex` of a PLY file (ascii, or binary of either byte order) from untrusted bytes. The
/// properties may have any order. Other elements and properties, lists included, are skipped, which is told in
/// a warning if everything is to be kept. Coordinates, colors,
/// labels and text are those of decode_pcd. What follows the vertices is only looked at: if it is damaged, missing or
/// more than the header promises, a warning says so.
///
/// The cloud is unorganized. PLY does not tell where the sensor is. So the view is that of the options, else that of a
/// comment that encode_ply wrote, else CAMERA if the points lie on the rays of a camera's pixels, else WORLD, with the
/// sensor at the origin if the points are the sweep of a LiDAR. LabeledCloud::view_rule says what was chosen, and why.
///
/// INVALID_ARGUMENT with a message of one line that names the fault and its place if the file is malformed or
/// truncated, has more vertices than 32 bits can count, or exceeds the limits. CANCELLED and DEADLINE_EXCEEDED as
/// `stop` says. A file of 0 points is no error here.
absl::StatusOr<LabeledCloud> decode_ply(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                        const ReadOptions& options = {}, const StopToken& stop = {});

/// Writes a PLY file whose vertices have x y z (float, or double if the content has a position in the file), red green
/// blue (uchar; if the cloud has color), the attributes, and label (uint; if there are labels). Both encodings keep
/// numbers, colors and labels exactly, but for attributes with integers of 64 bits, which become doubles; `warnings`,
/// if not null, is told of values that change. Comments tell the view, and the unit unless it is the meter. The rows
/// and columns of an organized cloud are lost. Names of attributes are changed as by encode_pcd.
std::string encode_ply(const FileContent& content, PlyEncoding encoding, std::vector<Warning>* warnings = nullptr);
/// Does the same for a cloud and its labels: one entry per point, or none.
std::string encode_ply(const CloudView& cloud, std::span<const std::uint32_t> label, PlyEncoding encoding);

}  // namespace segserve::codec
