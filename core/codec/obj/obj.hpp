// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "absl/status/statusor.h"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/codec/labeled_cloud.hpp"
#include "segserve/codec/read_options.hpp"
#include "segserve/stop_token.hpp"

// The vertices of Wavefront OBJ files.
namespace segserve::codec {

/// Whether a text is an OBJ file: whether its first line that is no comment begins as one of OBJ does.
bool is_obj(std::string_view file);

/// Decodes the vertices of an OBJ file: lines `v x y z`, `v x y z w` or `v x y z r g b`, whose colors count if all
/// vertices have one. Lines `vn` are the normals of the vertices if they are as many. Faces and all else are not
/// points, and are passed over. Warns of lines that no OBJ file has. INVALID_ARGUMENT names the line of a vertex that
/// is none; CANCELLED, DEADLINE_EXCEEDED.
absl::StatusOr<LabeledCloud> decode_obj(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                        const ReadOptions& options = {}, const StopToken& stop = {});

}  // namespace segserve::codec
