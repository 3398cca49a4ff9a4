// SPDX-License-Identifier: Apache-2.0
#include "segserve/client/payload.hpp"

#include <string>
#include <utility>
#include <vector>

#include "client/calls/payload_data.hpp"
#include "core/base/status_macros.hpp"
#include "proto/wire/cloud_message.hpp"
#include "proto/wire/codec_message.hpp"
#include "proto/wire/payload_blocks.hpp"
#include "segserve/codec/decode_limits.hpp"

namespace segserve::client {
namespace {

std::uint64_t decoded_bytes_of(const CloudView& cloud) {
  return cloud.size() * (3 * sizeof(float) + (cloud.has_color() ? 3 : 0));
}

}  // namespace

Payload::Payload() : Payload(std::make_shared<const PayloadData>()) {}

Payload::Payload(std::shared_ptr<const PayloadData> data) : data_(std::move(data)) {}

std::uint64_t Payload::bytes() const { return data_->run->size(); }

std::uint64_t Payload::points() const { return data_->points; }

std::uint64_t Payload::decoded_bytes() const { return data_->decoded_bytes; }

Payload make_payload(v1::Cloud message, std::uint64_t points, std::uint64_t decoded_bytes) {
  auto run = std::make_shared<const wire::ByteRun>(wire::payload_blocks(message));
  return Payload(
      std::make_shared<const PayloadData>(PayloadData{std::move(message), std::move(run), points, decoded_bytes}));
}

v1::Cloud message_of(const Payload& payload) {
  v1::Cloud message = payload.data().header;
  const std::vector<std::string*> empty = wire::payload_blocks(message);
  for (std::size_t i = 0; i < empty.size(); ++i) *empty[i] = payload.data().run->blocks()[i];
  return message;
}

absl::StatusOr<Payload> cloud_payload(const CloudView& cloud, const wire::CodecOptions& codec) {
  RETURN_IF_ERROR(check_shape(cloud));
  ASSIGN_OR_RETURN(v1::Cloud message, wire::to_message(cloud, codec));
  return make_payload(std::move(message), cloud.size(), decoded_bytes_of(cloud));
}

absl::StatusOr<Payload> cloud_payload(std::shared_ptr<const Cloud> cloud, const wire::CodecOptions& codec) {
  if (codec.codec != wire::Codec::kPlanar) return cloud_payload(CloudView(*cloud), codec);
  RETURN_IF_ERROR(check_shape(*cloud));
  PayloadData data;
  data.points = cloud->size();
  data.decoded_bytes = decoded_bytes_of(*cloud);
  wire::OutgoingCloud outgoing = wire::share_planar(std::move(cloud));
  data.header = std::move(outgoing.message);
  data.run = std::move(outgoing.bytes);
  return Payload(std::make_shared<const PayloadData>(std::move(data)));
}

Payload pcd_payload(std::string file_bytes, std::optional<View> view, std::optional<codec::LengthUnit> unit) {
  return make_payload(wire::to_pcd_message(std::move(file_bytes), std::move(view), unit));
}

Payload rgbd_payload(codec::RgbdFiles images) {
  v1::Cloud message = wire::to_rgbd_message(std::move(images));
  const std::uint64_t points = std::uint64_t{message.width()} * message.height();
  return make_payload(std::move(message), points);
}

absl::StatusOr<codec::LabeledCloud> decode(const Payload& payload, const StopToken& stop) {
  const v1::Cloud message = message_of(payload);
  ASSIGN_OR_RETURN(wire::DecodedCloud decoded, wire::decode_cloud(message, {.draco = true}, stop));
  codec::LabeledCloud cloud;
  cloud.cloud = std::move(decoded.cloud).to_cloud();
  cloud.view_rule = std::move(decoded.view_rule);
  cloud.warnings = std::move(decoded.warnings);
  cloud.placement = decoded.placement;
  return cloud;
}

}  // namespace segserve::client
