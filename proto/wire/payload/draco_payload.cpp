// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <utility>

#include "core/codec/common/finite_point_mask.hpp"
#include "proto/wire/block_message.hpp"
#include "proto/wire/payload/payload_codecs.hpp"
#include "proto/wire/payload/payload_support.hpp"
#include "segserve/codec/draco.hpp"

namespace segserve::wire {

absl::StatusOr<DecodedCloud> decode_draco(const v1::Cloud& message, const std::optional<View>& view,
                                          const codec::DecodeLimits& limits, const StopToken& stop) {
  const v1::DracoCloud& draco = message.draco();
  const std::uint64_t points = std::uint64_t{message.width()} * message.height();
  if (const absl::Status status = check_limits(points, 0, limits); !status.ok()) return status;
  std::string data_buffer;
  const auto data = block_bytes_up_to(draco.data(), limits.max_bytes, "cloud.draco.data", data_buffer);
  if (!data.ok()) return data.status();
  std::string finite_buffer;
  absl::StatusOr<std::string_view> finite = std::string_view();
  if (draco.has_finite()) {
    finite = block_bytes(draco.finite(), codec::bitmap_bytes(points), "cloud.draco.finite", finite_buffer);
  }
  if (!finite.ok()) return finite.status();
  absl::StatusOr<Cloud> cloud =
      codec::decode_draco(*data, *finite, message.width(), message.height(), *view, limits, stop);
  if (!cloud.ok()) return decode_error(cloud.status());
  return DecodedCloud{*std::move(cloud), requested_view_rule(*view)};
}

absl::StatusOr<v1::Cloud> to_draco_message(const CloudView& cloud, double error_bound) {
  absl::StatusOr<codec::DracoFile> file = codec::encode_draco(cloud, error_bound);
  if (!file.ok()) return file.status();
  v1::Cloud message = message_around(cloud);
  message.set_error_bound(error_bound);
  v1::DracoCloud& draco = *message.mutable_draco();
  *draco.mutable_data() = to_raw_block(std::move(file->data));
  if (!file->finite.empty()) {
    absl::StatusOr<v1::Block> finite = to_block(std::move(file->finite), v1::COMPRESSION_ZSTD);
    if (!finite.ok()) return finite.status();
    *draco.mutable_finite() = *std::move(finite);
  }
  return message;
}

}  // namespace segserve::wire
