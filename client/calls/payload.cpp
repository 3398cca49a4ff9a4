#include "segserve/client/payload.hpp"

#include <string>
#include <utility>

#include "proto/wire/cloud_message.hpp"
#include "proto/wire/payload_blocks.hpp"
#include "segserve/codec/decode_limits.hpp"

namespace segserve::client {

namespace {

wire::OutgoingCloud without_bytes(v1::Cloud message) {
  auto bytes = std::make_shared<const wire::ByteRun>(wire::payload_blocks(message));
  return {std::move(message), std::move(bytes)};
}

std::uint64_t decoded_bytes(const CloudView& cloud) {
  return cloud.size() * (3 * sizeof(float) + (cloud.has_color() ? 3 : 0));
}

}  // namespace

Payload::Payload(wire::OutgoingCloud cloud, std::uint64_t points, std::uint64_t decoded_bytes)
    : data_(
          std::make_shared<const Data>(Data{std::move(cloud.message), std::move(cloud.bytes), points, decoded_bytes})) {
}

Payload::Payload(v1::Cloud message, std::uint64_t points, std::uint64_t decoded_bytes)
    : Payload(without_bytes(std::move(message)), points, decoded_bytes) {}

v1::Cloud Payload::message() const {
  v1::Cloud message = header();
  const std::vector<std::string*> empty = wire::payload_blocks(message);
  for (std::size_t i = 0; i < empty.size(); ++i) *empty[i] = run()->blocks()[i];
  return message;
}

absl::StatusOr<Payload> cloud_payload(const CloudView& cloud, const wire::CodecOptions& codec) {
  if (absl::Status status = check_shape(cloud); !status.ok()) return status;
  auto message = wire::to_message(cloud, codec);
  if (!message.ok()) return message.status();
  return Payload(*std::move(message), cloud.size(), decoded_bytes(cloud));
}

absl::StatusOr<Payload> cloud_payload(std::shared_ptr<const Cloud> cloud, const wire::CodecOptions& codec) {
  if (codec.codec != wire::Codec::kPlanar) return cloud_payload(CloudView(*cloud), codec);
  if (absl::Status status = check_shape(*cloud); !status.ok()) return status;
  const std::uint64_t points = cloud->size(), bytes = decoded_bytes(*cloud);
  return Payload(wire::share_planar(std::move(cloud)), points, bytes);
}

Payload pcd_payload(std::string file_bytes, std::optional<View> view) {
  return Payload(wire::to_pcd_message(std::move(file_bytes), view));
}

Payload rgbd_payload(codec::RgbdFiles images) {
  v1::Cloud message = wire::to_rgbd_message(std::move(images));
  const std::uint64_t points = std::uint64_t{message.width()} * message.height();
  return Payload(std::move(message), points);
}

absl::StatusOr<codec::LabelledCloud> decode(const Payload& payload, const StopToken& stop) {
  const v1::Cloud message = payload.message();
  auto decoded = wire::decode_cloud(message, {.draco = true}, stop);
  if (!decoded.ok()) return decoded.status();
  return codec::LabelledCloud{std::move(decoded->cloud).to_cloud(), {}, std::move(decoded->view_rule)};
}

}  // namespace segserve::client
