#include "segserve/client/payload.hpp"

#include <string>
#include <utility>

#include "segserve/codec/limits.hpp"
#include "segserve/wire/cloud.hpp"
#include "segserve/wire/payload_blocks.hpp"

namespace segserve::client {

Payload::Payload(v1::Cloud message, std::uint64_t points, std::uint64_t decoded_bytes) {
  auto data = std::make_shared<Data>();
  data->run = std::make_shared<const wire::ByteRun>(wire::payload_blocks(message));
  data->header = std::move(message);
  data->points = points;
  data->decoded_bytes = decoded_bytes;
  data_ = std::move(data);
}

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
  const std::uint64_t point_bytes = 3 * sizeof(float) + (cloud.has_color() ? 3 : 0);
  return Payload(*std::move(message), cloud.size(), cloud.size() * point_bytes);
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
  auto decoded = wire::decode_cloud(payload.message(), {.draco = true}, stop);
  if (!decoded.ok()) return decoded.status();
  return codec::LabelledCloud{std::move(decoded->cloud), {}, std::move(decoded->view_rule)};
}

}  // namespace segserve::client
