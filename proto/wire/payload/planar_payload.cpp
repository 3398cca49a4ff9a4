// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/status_macros.hpp"
#include "proto/wire/block_message.hpp"
#include "proto/wire/payload/payload_codecs.hpp"
#include "proto/wire/payload/payload_support.hpp"
#include "segserve/codec/planar.hpp"

namespace segserve::wire {
namespace {

constexpr std::uint64_t kCoordinateBytes = 4;
constexpr std::uint64_t kColorBytes = 3;

/// The bytes of the planes of a message. A plane that was compressed lies in `buffers`, and the others in the message.
absl::StatusOr<codec::PlanarBytes> read_planes(const v1::PlanarCloud& message, std::uint64_t points, bool has_color,
                                               const StopToken& stop, codec::PlanarPlanes& buffers) {
  const std::uint64_t plane_bytes = kCoordinateBytes * points;
  codec::PlanarBytes planes;
  RETURN_IF_ERROR(stop.check());
  ASSIGN_OR_RETURN(planes.x, block_bytes(message.x(), plane_bytes, "cloud.planar.x", buffers.x));
  RETURN_IF_ERROR(stop.check());
  ASSIGN_OR_RETURN(planes.y, block_bytes(message.y(), plane_bytes, "cloud.planar.y", buffers.y));
  RETURN_IF_ERROR(stop.check());
  ASSIGN_OR_RETURN(planes.z, block_bytes(message.z(), plane_bytes, "cloud.planar.z", buffers.z));
  if (has_color) {
    RETURN_IF_ERROR(stop.check());
    ASSIGN_OR_RETURN(planes.rgb, block_bytes(message.rgb(), kColorBytes * points, "cloud.planar.rgb", buffers.rgb));
  }
  return planes;
}

}  // namespace

absl::StatusOr<DecodedCloud> decode_planar(const v1::Cloud& message, const std::optional<View>& view,
                                           const codec::DecodeLimits& limits, const StopToken& stop) {
  const v1::PlanarCloud& planar = message.planar();
  const std::uint64_t points = points_of_shape(message);
  const bool has_color = !planar.rgb().data().empty() || planar.rgb().decoded_bytes() != 0;
  // The points are checked first, so that the product below cannot overflow.
  RETURN_IF_ERROR(check_limits(points, 0, limits));
  const std::uint64_t bytes = points * (3 * kCoordinateBytes + (has_color ? kColorBytes : 0));
  RETURN_IF_ERROR(check_limits(points, bytes, limits));

  codec::PlanarPlanes buffers;
  ASSIGN_OR_RETURN(const codec::PlanarBytes planes, read_planes(planar, points, has_color, stop, buffers));
  ASSIGN_OR_RETURN(BorrowingCloud cloud, with_decode_reason(codec::decode_planar(
                                             planes, message.width(), message.height(), *view, limits, stop)));
  const bool uses_buffers = !buffers.x.empty() || !buffers.y.empty() || !buffers.z.empty();
  if (uses_buffers) cloud = std::move(cloud).to_cloud();
  return DecodedCloud{std::move(cloud), requested_view_rule(*view)};
}

absl::StatusOr<v1::Cloud> to_planar_message(const CloudView& cloud, v1::Compression compression) {
  codec::PlanarPlanes planes = codec::encode_planar(cloud);
  v1::Cloud message = message_without_payload(cloud);
  v1::PlanarCloud& planar = *message.mutable_planar();
  ASSIGN_OR_RETURN(*planar.mutable_x(), to_block(std::move(planes.x), compression));
  ASSIGN_OR_RETURN(*planar.mutable_y(), to_block(std::move(planes.y), compression));
  ASSIGN_OR_RETURN(*planar.mutable_z(), to_block(std::move(planes.z), compression));
  if (cloud.has_color()) {
    ASSIGN_OR_RETURN(*planar.mutable_rgb(), to_block(std::move(planes.rgb), compression));
  }
  return message;
}

OutgoingCloud share_planar(std::shared_ptr<const Cloud> cloud) {
  OutgoingCloud out{message_without_payload(*cloud), nullptr};
  struct Owner {
    std::shared_ptr<const Cloud> cloud;
    std::unique_ptr<char[]> rgb;
  };
  const auto owner = std::make_shared<Owner>();
  const codec::PlanarBytes planes = codec::encode_planar_in_place(*cloud, owner->rgb);
  owner->cloud = std::move(cloud);
  v1::PlanarCloud& planar = *out.message.mutable_planar();
  std::vector<std::string_view> blocks;
  const auto announce = [&blocks](std::string_view bytes, v1::Block& block) {
    block.set_compression(v1::COMPRESSION_NONE);
    block.set_decoded_bytes(bytes.size());
    block.set_encoded_bytes(bytes.size());
    blocks.push_back(bytes);
  };
  announce(planes.x, *planar.mutable_x());
  announce(planes.y, *planar.mutable_y());
  announce(planes.z, *planar.mutable_z());
  if (owner->cloud->has_color()) announce(planes.rgb, *planar.mutable_rgb());
  out.bytes = std::make_shared<const ByteRun>(std::move(blocks), owner);
  return out;
}

}  // namespace segserve::wire
