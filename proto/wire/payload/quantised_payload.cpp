// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <utility>

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
  const auto bytes = block_bytes_up_to(message.quantised().data(), limits.max_bytes, "cloud.quantised.data", buffer);
  if (!bytes.ok()) return bytes.status();
  absl::StatusOr<codec::QuantisedCloud> decoded = codec::decode_quantised(*bytes, *view, limits, stop);
  if (!decoded.ok()) return decode_error(decoded.status());
  if (absl::Status status = check_shape_agrees(message, decoded->cloud, "the quantised cloud"); !status.ok()) {
    return status;
  }
  if (message.error_bound() != decoded->error_bound) {
    return invalid_fields({{"cloud.error_bound", fmt::format("{} m, but the quantised cloud says {} m",
                                                             message.error_bound(), decoded->error_bound)}});
  }
  return DecodedCloud{std::move(decoded->cloud), requested_view_rule(*view)};
}

absl::StatusOr<v1::Cloud> to_quantised_message(const CloudView& cloud, double error_bound) {
  absl::StatusOr<std::string> bytes = codec::encode_quantised(cloud, error_bound);
  if (!bytes.ok()) return bytes.status();
  v1::Cloud message = message_around(cloud);
  message.set_error_bound(error_bound);
  *message.mutable_quantised()->mutable_data() = to_raw_block(*std::move(bytes));
  return message;
}

}  // namespace segserve::wire
