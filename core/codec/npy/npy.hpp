// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/codec/labeled_cloud.hpp"
#include "segserve/codec/read_options.hpp"
#include "segserve/stop_token.hpp"

// Arrays of NumPy.
namespace segserve::codec {

/// Decodes an array of numbers of any type, byte order and order of axes:
///
///  - shape (N, C) or (H, W, C) with C >= 3 columns, whose values tell what they are (name_columns)
///  - shape (N) or (H, W) with named fields: x, y, z, or one of the names below with 3 numbers; color, label and other
///    values by their names (find_field_roles). Titles may be statements of segserve.
///
/// INVALID_ARGUMENT names what is wrong, or that the elements are Python objects; CANCELLED, DEADLINE_EXCEEDED.
absl::StatusOr<LabeledCloud> decode_npy(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                        const ReadOptions& options = {}, const StopToken& stop = {});

/// Whether the file is a zip archive, as NPZ is.
bool is_npz(std::string_view file);

/// Decodes an archive of arrays: `points`, `xyz`, `pos`, `positions`, `coord`, `coords` or `vertices` of shape (N, C)
/// or (H, W, C), or `x`, `y` and `z`; `colors`, `color` or `rgb`; `labels` or `label`. An archive of a single array is
/// read as that array. Other arrays of as many points are attributes, the rest is not kept, with a warning. Members may
/// be stored or deflated. Errors are those of decode_npy.
absl::StatusOr<LabeledCloud> decode_npz(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                        const ReadOptions& options = {}, const StopToken& stop = {});

/// Encodes a cloud as an array with named fields (x, y, z, red, green, blue, the attributes, label) of version 2.0, of
/// shape (H, W) if the cloud is organized, else (N). The titles of x and y are the statements_of the content.
std::string encode_npy(const FileContent& content);

}  // namespace segserve::codec
