// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "absl/status/status.h"
#include "google/protobuf/message.h"
#include "grpcpp/support/byte_buffer.h"

namespace segserve::wire {

/// The most values in one message from a client: fields, entries of repeated fields and unknown fields, in all messages
/// within it. A parsed value takes up to some hundred bytes, however few it has on the wire, so that this bounds the
/// memory of a parsed message to its size on the wire and 1 MiB. An honest message has less than a hundred values.
inline constexpr std::size_t kMostMessageValues = 4096;

/// Parses the message after it has looked at its bytes: they hold at most kMostMessageValues values, in at most 16
/// levels of messages. Unknown fields are dropped. The buffer is empty afterwards. `name` is that of the message in
/// errors. INVALID_ARGUMENT, MALFORMED_PAYLOAD.
absl::Status parse_bounded(grpc::ByteBuffer& bytes, const char* name, google::protobuf::Message& message);

}  // namespace segserve::wire
