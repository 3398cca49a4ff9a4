// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/v1/cloud.pb.h"
#include "segserve/v1/server_info.pb.h"
#include "segserve/wire/codec.hpp"

// The codecs, their names and the kinds of payload that they make. decode_cloud of cloud_message.hpp decodes all of
// them.
namespace segserve::wire {

/// The name and the properties of a codec.
struct CodecInfo {
  Codec codec;
  std::string_view name;  ///< its name on the command line, e.g. "planar-zstd"
  v1::PayloadKind kind;   ///< the kind of payload that it makes
  bool is_lossless;
  std::string_view description;  ///< one line for people
};

/// The codecs that this build can encode.
std::span<const CodecInfo> codecs();

/// The entry of a codec, also of Draco if this build cannot encode it.
const CodecInfo& info(Codec codec);

/// Encodes a cloud, with its view. The order of the points is kept, whatever the codec. A lossy message declares its
/// error bound. INVALID_ARGUMENT if the codec cannot encode the cloud: kQuantised and kDraco need coordinates that are
/// not too large for the error bound, kRgbd needs an organized CAMERA cloud of a pinhole camera. INTERNAL if a library
/// fails.
absl::StatusOr<v1::Cloud> to_message(const CloudView& cloud, const CodecOptions& options);

/// The name of a kind of payload, as the field of v1.Cloud is called, e.g. "pcd_file"; "unknown" for other numbers.
std::string_view name(v1::PayloadKind kind);

/// The kind of the payload of a message; PAYLOAD_KIND_UNSPECIFIED if it has none.
v1::PayloadKind kind_of(const v1::Cloud& message);

/// The kinds of payload that decode_cloud accepts under these limits.
std::vector<v1::PayloadKind> accepted_kinds(const codec::DecodeLimits& limits);

/// OK if there is no payload, or one of an accepted kind. INVALID_ARGUMENT, INVALID_FIELD otherwise, with a message
/// that lists the accepted kinds. The payload's bytes are not read.
absl::Status check_kind(const v1::Cloud& message, const codec::DecodeLimits& limits);

}  // namespace segserve::wire
