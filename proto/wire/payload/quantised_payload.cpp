// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <utility>

#include "core/base/status_macros.hpp"
#include "fmt/format.h"
#include "proto/wire/block_message.hpp"
#include "proto/wire/payload/payload_codecs.hpp"
#include "proto/wire/payload/payload_support.hpp"
#include "proto/wire/status_message.hpp"
#include "segserve/codec/quantised.hpp"

namespace segserve::wire {

absl::StatusOr<DecodedCloud> decode_quantised(const v1::Cloud& message, const std::optional<View>& view,
                                              const codec::DecodeLimits& limits, const StopToken& stop) {
  std::string buffer;
  ASSIGN_OR_RETURN(const std::string_view bytes,
                   block_bytes_up_to(message.quantised().data(), limits.max_bytes, "cloud.quantised.data", buffer));
  ASSIGN_OR_RETURN(codec::QuantisedCloud decoded,
                   with_decode_reason(codec::decode_quantised(bytes, *view, limits, stop)));
  RETURN_IF_ERROR(check_shape_agrees(message, decoded.cloud, "the quantised cloud"));
  if (message.error_bound() != decoded.error_bound) {
    return invalid_fields({{"cloud.error_bound", fmt::format("the message says {} m, but the quantised cloud has {} m",
                                                             message.error_bound(), decoded.error_bound)}});
  }
  return DecodedCloud{std::move(decoded.cloud), requested_view_rule(*view)};
}

absl::StatusOr<v1::Cloud> to_quantised_message(const CloudView& cloud, double error_bound) {
  ASSIGN_OR_RETURN(std::string bytes, codec::encode_quantised(cloud, error_bound));
  v1::Cloud message = message_without_payload(cloud);
  message.set_error_bound(error_bound);
  *message.mutable_quantised()->mutable_data() = to_raw_block(std::move(bytes));
  return message;
}

}  // namespace segserve::wire
