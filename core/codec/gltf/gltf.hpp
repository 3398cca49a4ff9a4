// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "absl/status/statusor.h"
#include "segserve/codec/file_format.hpp"
#include "segserve/codec/labeled_cloud.hpp"

namespace segserve::codec {

/// How a glTF file holds its numbers.
enum class GltfForm : std::uint8_t {
  kBinary,  ///< .glb: a block of bytes behind the JSON
  kText,    ///< .gltf: base64 within the JSON
};

/// Encodes a cloud as glTF 2.0 (Khronos Group): a node with a mesh of POINTS for each segment, in the order of the
/// labels, named `segment 12`, or `unlabeled` for label 0. The coordinates are those of `content.cloud`, in meters near
/// the origin, turned so that y points up: (x, z, -y) of a WORLD cloud, whose z points up, and (x, -y, -z) of a
/// camera's frame. Colors are normalized bytes. Warns of points that are not finite, which are left out, of attributes,
/// and of coordinates that are not those of the file. INVALID_ARGUMENT if the file would be larger than 4 GiB.
absl::StatusOr<EncodedFile> encode_gltf(const FileContent& content, GltfForm form);

}  // namespace segserve::codec
