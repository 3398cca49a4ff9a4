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

// The ways in which a cloud can be sent, by name. Receivers tell them from the message: see wire::decode_cloud.
namespace segserve::wire {

struct CodecInfo {
  Codec codec;
  std::string_view name;  ///< as the command line writes it, e.g. "planar-zstd"
  v1::PayloadKind kind;
  bool is_lossless;
  std::string_view description;
};

/// All that this build can encode.
std::span<const CodecInfo> codecs();

/// Of one of codecs(). Draco's is there even if this build cannot encode it.
const CodecInfo& info(Codec codec);

/// The cloud in its own view, ready to be sent. Labels come back in the order of its points, whatever the codec.
/// INVALID_ARGUMENT for what a codec cannot encode: quantised and Draco coordinates that are too large for the bound;
/// RGB-D anything but an organized CAMERA cloud of a pinhole camera. A lossy message declares its error bound.
absl::StatusOr<v1::Cloud> to_message(const CloudView& cloud, const CodecOptions& options);

/// A kind of payload as the API's field is called: "pcd_file".
std::string_view name(v1::PayloadKind kind);

/// What decode_cloud accepts under these limits.
std::vector<v1::PayloadKind> accepted_kinds(const codec::DecodeLimits& limits);

/// OK if the payload is of an accepted kind (or there is none); else INVALID_FIELD that lists those that are. A look at
/// the message without its bytes.
absl::Status check_kind(const v1::Cloud& message, const codec::DecodeLimits& limits);

}  // namespace segserve::wire
