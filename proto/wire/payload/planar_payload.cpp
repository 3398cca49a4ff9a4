// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <utility>

#include "proto/wire/block_message.hpp"
#include "proto/wire/payload/payload_codecs.hpp"
#include "proto/wire/payload/payload_support.hpp"
#include "segserve/codec/planar.hpp"

namespace segserve::wire {
namespace {

constexpr std::uint64_t kCoordinateBytes = 4;
constexpr std::uint64_t kColorBytes = 3;

/// One plane after the other, so that an error names its block.
class PlaneReader {
 public:
  explicit PlaneReader(const StopToken& stop) : stop_(stop) {}

  std::string_view read(const v1::Block& block, std::uint64_t bytes, std::string_view name, std::string& buffer) {
    if (status_.ok()) status_ = stop_.check();
    if (!status_.ok()) return {};
    const absl::StatusOr<std::string_view> plane = block_bytes(block, bytes, name, buffer);
    status_ = plane.status();
    return plane.ok() ? *plane : std::string_view();
  }
  const absl::Status& status() const { return status_; }

 private:
  const StopToken& stop_;
  absl::Status status_;
};

}  // namespace

absl::StatusOr<DecodedCloud> decode_planar(const v1::Cloud& message, const std::optional<View>& view,
                                           const codec::DecodeLimits& limits, const StopToken& stop) {
  const v1::PlanarCloud& planar = message.planar();
  const std::uint64_t points = std::uint64_t{message.width()} * message.height();
  const bool has_color = !planar.rgb().data().empty() || planar.rgb().decoded_bytes() != 0;
  // A point takes at most 15 bytes, so the product cannot overflow once max_points is kept.
  if (const absl::Status status = check_limits(points, 0, limits); !status.ok()) return status;
  const std::uint64_t bytes = points * (3 * kCoordinateBytes + (has_color ? kColorBytes : 0));
  if (const absl::Status status = check_limits(points, bytes, limits); !status.ok()) return status;

  codec::PlanarPlanes buffers;
  codec::PlanarBytes planes;
  PlaneReader reader(stop);
  planes.x = reader.read(planar.x(), kCoordinateBytes * points, "cloud.planar.x", buffers.x);
  planes.y = reader.read(planar.y(), kCoordinateBytes * points, "cloud.planar.y", buffers.y);
  planes.z = reader.read(planar.z(), kCoordinateBytes * points, "cloud.planar.z", buffers.z);
  if (has_color) planes.rgb = reader.read(planar.rgb(), kColorBytes * points, "cloud.planar.rgb", buffers.rgb);
  if (!reader.status().ok()) return reader.status();

  auto cloud = codec::decode_planar(planes, message.width(), message.height(), *view, limits, stop);
  if (!cloud.ok()) return decode_error(cloud.status());
  const bool decompressed = !buffers.x.empty() || !buffers.y.empty() || !buffers.z.empty();
  if (decompressed) cloud = (*std::move(cloud)).to_cloud();  // the buffers end here
  return DecodedCloud{*std::move(cloud), requested_view_rule(*view)};
}

absl::StatusOr<v1::Cloud> to_planar_message(const CloudView& cloud, v1::Compression compression) {
  codec::PlanarPlanes planes = codec::encode_planar(cloud);
  v1::Cloud message = message_around(cloud);
  v1::PlanarCloud* planar = message.mutable_planar();
  const auto put = [compression](std::string& plane, v1::Block* block) {
    absl::StatusOr<v1::Block> made = to_block(std::move(plane), compression);
    if (!made.ok()) return made.status();
    *block = *std::move(made);
    return absl::OkStatus();
  };
  absl::Status status = put(planes.x, planar->mutable_x());
  if (status.ok()) status = put(planes.y, planar->mutable_y());
  if (status.ok()) status = put(planes.z, planar->mutable_z());
  if (status.ok() && cloud.has_color()) status = put(planes.rgb, planar->mutable_rgb());
  if (!status.ok()) return status;
  return message;
}

OutgoingCloud share_planar(std::shared_ptr<const Cloud> cloud) {
  OutgoingCloud out{message_around(*cloud), nullptr};
  struct Owner {
    std::shared_ptr<const Cloud> cloud;
    std::unique_ptr<char[]> rgb;
  };
  const auto owner = std::make_shared<Owner>();
  const codec::PlanarBytes planes = codec::encode_planar_in_place(*cloud, owner->rgb);
  owner->cloud = std::move(cloud);
  v1::PlanarCloud* planar = out.message.mutable_planar();
  std::vector<std::string_view> blocks;
  const auto put = [&blocks](std::string_view bytes, v1::Block* block) {
    block->set_compression(v1::COMPRESSION_NONE);
    block->set_decoded_bytes(bytes.size());
    block->set_encoded_bytes(bytes.size());
    blocks.push_back(bytes);
  };
  put(planes.x, planar->mutable_x());
  put(planes.y, planar->mutable_y());
  put(planes.z, planar->mutable_z());
  if (owner->cloud->has_color()) put(planes.rgb, planar->mutable_rgb());
  out.bytes = std::make_shared<const ByteRun>(std::move(blocks), owner);
  return out;
}

}  // namespace segserve::wire
