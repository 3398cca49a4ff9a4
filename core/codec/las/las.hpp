// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

#include "absl/status/statusor.h"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/codec/file_format.hpp"
#include "segserve/codec/labeled_cloud.hpp"
#include "segserve/codec/read_options.hpp"
#include "segserve/stop_token.hpp"

// LAS files (American Society for Photogrammetry and Remote Sensing, "LAS Specification").
namespace segserve::codec {

/// Decodes a LAS file of version 1.0 to 1.4 with points of any format. The coordinates are scale * integer + offset in
/// doubles. An extra dimension `segment`, `label` or `scalar_Label` is the label; the classification is none, because
/// it tells what a point is, and not which thing it belongs to. All other values are attributes; those of the
/// specification are left out if they are 0 for all points, or if each point is the only return of its pulse. A file
/// that is cut off gives its whole points, with a warning. The unit is that of the coordinate reference system, if
/// neither the options nor a statement of segserve have one. INVALID_ARGUMENT names what is wrong, that the file is
/// LAZ, or that the coordinates are latitudes and longitudes by their system and values, and no unit is given;
/// CANCELLED, DEADLINE_EXCEEDED.
absl::StatusOr<LabeledCloud> decode_las(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                        const ReadOptions& options = {}, const StopToken& stop = {});

/// Encodes a cloud as LAS 1.4 with points of format 7, or 6 if there is no color. Positions of floats are scaled by a
/// power of two, so that they stay exact but for the last bits of numbers that are small beside the largest; doubles by
/// a power of ten, the smallest that 32 bits allow, 1e-9 at least. Labels are the extra dimension `segment`. Attributes
/// go to the fields of their names if these can hold them, else they are extra dimensions. Records of segserve tell
/// the view, and the unit unless it is the meter. Warns of points that are not finite, which LAS cannot have and which
/// are left out, and of values that do not fit. INVALID_ARGUMENT if a coordinate is too large.
absl::StatusOr<EncodedFile> encode_las(const FileContent& content);

}  // namespace segserve::codec
