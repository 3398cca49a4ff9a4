// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "proto/wire/byte_run.hpp"
#include "segserve/cloud.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/codec/length_unit.hpp"
#include "segserve/codec/placement.hpp"
#include "segserve/codec/rgbd_encode.hpp"
#include "segserve/codec/warning.hpp"
#include "segserve/options.hpp"
#include "segserve/v1/cloud.pb.h"

namespace segserve::wire {

/// The message of a view.
v1::View to_message(const View& view);

/// The message of a unit, and the unit of a message; nullopt if it is unknown.
v1::LengthUnit to_message(codec::LengthUnit unit);
std::optional<codec::LengthUnit> from_message(v1::LengthUnit message);

/// The view of a message; nullopt if its kind is unspecified or unknown. Appends what is wrong with the message to
/// `faults`, with paths such as "cloud.view.sensor".
std::optional<View> from_message(const v1::View& message, std::vector<FieldViolation>& faults);

/// Encodes a cloud as planes, each of which may be compressed. codec_message.hpp has the function for all codecs.
/// INTERNAL if Zstandard fails.
absl::StatusOr<v1::Cloud> to_planar_message(const CloudView& cloud, v1::Compression compression);

/// A cloud to send in a stream: the message and, apart from it, the bytes of its blocks.
struct OutgoingCloud {
  v1::Cloud message;                     ///< its blocks have their sizes, but no data
  std::shared_ptr<const ByteRun> bytes;  ///< the data of all blocks
};

/// Encodes a cloud as planes without compression. The coordinates are not copied: `bytes` refers to those of `cloud`,
/// keeps it alive, and expects it not to change.
OutgoingCloud share_planar(std::shared_ptr<const Cloud> cloud);

/// The message that holds a PCD file. The view and the unit, if they are given, override those of the file.
v1::Cloud to_pcd_message(std::string file_bytes, std::optional<View> view,
                         std::optional<codec::LengthUnit> unit = std::nullopt);

/// The message that holds the images of an RGB-D camera. It has the shape of the depth image, or none if that is of no
/// known format.
v1::Cloud to_rgbd_message(codec::RgbdFiles images);

/// All faults of the fields around the payload, with paths such as "cloud.view". The payload's bytes are not read.
std::vector<FieldViolation> violations(const v1::Cloud& message);

/// A cloud that was decoded from a message.
struct DecodedCloud {
  BorrowingCloud cloud;                       ///< its planes may lie in the message, which must outlive it
  std::string view_rule;                      ///< one line for people that says why the cloud has its view
  std::vector<codec::Warning> warnings = {};  ///< what the payload has that was not used
  codec::Placement placement = {};            ///< from the payload's coordinates to those of the cloud
};

/// Decodes the payload of a message. The sizes that it claims are compared with the limits before anything is
/// allocated. INVALID_ARGUMENT with one of these reasons: INVALID_FIELD (`violations`, or `check_kind` of
/// codec_message.hpp), MALFORMED_PAYLOAD, LIMIT_EXCEEDED. CANCELLED or DEADLINE_EXCEEDED as `stop` says.
absl::StatusOr<DecodedCloud> decode_cloud(const v1::Cloud& message, const codec::DecodeLimits& limits,
                                          const StopToken& stop = {});
// A temporary message would not outlive the cloud.
absl::StatusOr<DecodedCloud> decode_cloud(const v1::Cloud&& message, const codec::DecodeLimits& limits,
                                          const StopToken& stop = {}) = delete;

}  // namespace segserve::wire
