// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/codec/common/finite_point_mask.hpp"
#include "proto/wire/block_message.hpp"
#include "proto/wire/payload/payload_codecs.hpp"
#include "proto/wire/payload/payload_support.hpp"
#include "segserve/codec/draco.hpp"

namespace segserve::wire {

absl::StatusOr<DecodedCloud> decode_draco(const v1::Cloud& message, const std::optional<View>& view,
                                          const codec::DecodeLimits& limits, const StopToken& stop) {
  const v1::DracoCloud& draco = message.draco();
  const std::uint64_t points = points_of_shape(message);
  RETURN_IF_ERROR(check_limits(points, 0, limits));
  std::string data_buffer;
  ASSIGN_OR_RETURN(const std::string_view data,
                   block_bytes_up_to(draco.data(), limits.max_bytes, "cloud.draco.data", data_buffer));
  std::string finite_buffer;
  std::string_view finite;
  if (draco.has_finite()) {
    ASSIGN_OR_RETURN(finite,
                     block_bytes(draco.finite(), codec::bitmap_bytes(points), "cloud.draco.finite", finite_buffer));
  }
  ASSIGN_OR_RETURN(Cloud cloud, with_decode_reason(codec::decode_draco(data, finite, message.width(), message.height(),
                                                                       *view, limits, stop)));
  return DecodedCloud{std::move(cloud), requested_view_rule(*view)};
}

absl::StatusOr<v1::Cloud> to_draco_message(const CloudView& cloud, double error_bound) {
  ASSIGN_OR_RETURN(codec::DracoFile file, codec::encode_draco(cloud, error_bound));
  v1::Cloud message = message_without_payload(cloud);
  message.set_error_bound(error_bound);
  v1::DracoCloud& draco = *message.mutable_draco();
  *draco.mutable_data() = to_raw_block(std::move(file.data));
  if (!file.finite.empty()) {
    ASSIGN_OR_RETURN(*draco.mutable_finite(), to_block(std::move(file.finite), v1::COMPRESSION_ZSTD));
  }
  return message;
}

}  // namespace segserve::wire
