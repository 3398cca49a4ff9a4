// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "google/protobuf/message.h"
#include "server/http/http_message.hpp"

// Unary calls of the protocol Connect (https://connectrpc.com/docs/protocol), by which browsers call the service.
namespace segserve::server {

/// How messages are encoded.
enum class ConnectCodec : std::uint8_t { kProto, kJson };

/// The codec of the type of content of a request; nullopt if it is none of a unary call.
std::optional<ConnectCodec> connect_codec(std::string_view content_type);

/// The type of content of a codec.
std::string_view content_type(ConnectCodec codec);

/// The time that the caller gives the call, from Connect-Timeout-Ms; nullopt if it gives none. INVALID_ARGUMENT,
/// INVALID_FIELD for a header that is wrong, and for a compression of the whole body: payloads have their own, whose
/// results are bounded.
absl::StatusOr<std::optional<std::chrono::milliseconds>> connect_timeout(const HttpHead& head);

/// Reads a message within the bounds of wire::parse_bounded. `name` is that of the message in errors. INVALID_ARGUMENT,
/// MALFORMED_PAYLOAD.
absl::Status parse_connect(ConnectCodec codec, std::string body, const char* name, google::protobuf::Message& message);

/// The bytes of memory that parsing a body of so many bytes takes, with the body.
std::uint64_t parsing_bytes(ConnectCodec codec, std::uint64_t body_bytes);

/// The answer that holds a message.
absl::StatusOr<HttpAnswer> connect_answer(ConnectCodec codec, const google::protobuf::Message& message);

}  // namespace segserve::server
