// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"
#include "segserve/codec/labeled_cloud.hpp"
#include "segserve/codec/length_unit.hpp"
#include "segserve/codec/rgbd_encode.hpp"
#include "segserve/stop_token.hpp"
#include "segserve/wire/codec.hpp"

namespace segserve::client {

struct PayloadData;

/// A cloud as it goes over the wire: encoded once and sent any number of times. Copies share the bytes, and any number
/// of threads may use them.
///
///     const auto payload = cloud_payload(cloud, {.codec = wire::Codec::kPlanarZstd});
///     if (payload.ok()) stream.send(*payload);
class Payload {
 public:
  /// An empty payload, which no server accepts.
  Payload();
  /// Used by the library itself; the functions below make payloads.
  explicit Payload(std::shared_ptr<const PayloadData> data);

  /// The size of the encoded bytes.
  std::uint64_t bytes() const;
  /// The number of points in the cloud; 0 if only a decoder can tell.
  std::uint64_t points() const;
  /// The size of the decoded cloud, bytes; 0 if only a decoder can tell.
  std::uint64_t decoded_bytes() const;
  /// Used by the library itself.
  const PayloadData& data() const { return *data_; }

 private:
  std::shared_ptr<const PayloadData> data_;
};

/// Encodes a cloud in its own view; by default as planar raw. INVALID_ARGUMENT if the planes do not fit each other, or
/// the codec cannot encode the cloud.
absl::StatusOr<Payload> cloud_payload(const CloudView& cloud, const wire::CodecOptions& codec = {});

/// Does the same for a cloud that is shared. The codec `planar` does not copy its coordinates: they must not change
/// while the payload is in use.
absl::StatusOr<Payload> cloud_payload(std::shared_ptr<const Cloud> cloud, const wire::CodecOptions& codec = {});

/// Sends a PCD file as it is. The view, if given, overrides the file's, and so does the unit of its coordinates.
/// The server says if the file is broken.
Payload pcd_payload(std::string file_bytes, std::optional<View> view = std::nullopt,
                    std::optional<codec::LengthUnit> unit = std::nullopt);

/// Sends the images of an RGB-D camera as they are. The server says if they are broken.
Payload rgbd_payload(codec::RgbdFiles images);

/// The cloud that a server makes of the payload, and the rule by which it chose the view. INVALID_ARGUMENT if the
/// payload is broken; the status of `stop` once it says so.
absl::StatusOr<codec::LabeledCloud> decode(const Payload& payload, const StopToken& stop = {});

}  // namespace segserve::client
