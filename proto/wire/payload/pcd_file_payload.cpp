// SPDX-License-Identifier: Apache-2.0
#include <span>
#include <string>
#include <utility>

#include "core/base/status_macros.hpp"
#include "proto/wire/block_message.hpp"
#include "proto/wire/payload/payload_codecs.hpp"
#include "proto/wire/payload/payload_support.hpp"
#include "segserve/codec/pcd.hpp"

namespace segserve::wire {

absl::StatusOr<DecodedCloud> decode_pcd_file(const v1::Cloud& message, const codec::ReadOptions& options,
                                             const codec::DecodeLimits& limits, const StopToken& stop) {
  std::string buffer;
  ASSIGN_OR_RETURN(const std::string_view bytes,
                   block_bytes_up_to(message.pcd_file().file(), limits.max_bytes, "cloud.pcd_file.file", buffer));
  ASSIGN_OR_RETURN(auto decoded,
                   with_decode_reason(codec::decode_pcd(std::as_bytes(std::span(bytes)), limits, options, stop)));
  RETURN_IF_ERROR(check_shape_agrees(message, decoded.cloud, "the PCD file"));
  return decoded_cloud(std::move(decoded));
}

v1::Cloud to_pcd_message(std::string file_bytes, std::optional<View> view, std::optional<codec::LengthUnit> unit) {
  v1::Cloud message;
  if (unit) message.set_unit(to_message(*unit));
  if (view) *message.mutable_view() = to_message(*view);
  *message.mutable_pcd_file()->mutable_file() = to_raw_block(std::move(file_bytes));
  return message;
}

}  // namespace segserve::wire
