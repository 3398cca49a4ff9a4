// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "google/rpc/status.pb.h"
#include "grpcpp/support/status.h"
#include "segserve/options.hpp"
#include "segserve/wire/error_details.hpp"

// Only these functions turn the statuses of core into those of gRPC, and back. An absl::Status carries its details as
// payloads: google.rpc messages under their Any type URLs.
namespace segserve::wire {

/// The status with these details instead of those that it had. An OK status stays as it is.
absl::Status with_details(absl::Status status, const ErrorDetails& details);

/// The status with this reason. A status that is OK or has a reason stays as it is.
absl::Status with_reason(absl::Status status, ErrorReason reason);

/// INVALID_ARGUMENT, MALFORMED_PAYLOAD: the bytes are not what they claim to be.
absl::Status malformed(std::string_view message);

/// INVALID_ARGUMENT, MALFORMED_PAYLOAD with the message of `cause`. `name` is the part of the message that is damaged.
absl::Status malformed(std::string_view name, const absl::Status& cause);

/// INVALID_ARGUMENT, INVALID_FIELD with a message that lists every wrong field. OK if there are none.
absl::Status invalid_fields(const std::vector<FieldViolation>& fields);

/// INVALID_ARGUMENT, LIMIT_EXCEEDED with a message such as "the cloud has 7 points, more than max_points = 5". There
/// `subject` is "the cloud has", `unit` is "points", and `limit` is "max_points", a field of v1.Limits.
absl::Status limit_exceeded(std::string_view subject, std::uint64_t actual, std::string_view unit,
                            std::string_view limit, std::uint64_t allowed);

/// The status as a client sees it: one without a reason gets the one that its code implies, and a code that the API
/// does not list becomes INTERNAL.
absl::Status as_told(const absl::Status& status);

/// The message of as_told(status) with its details, as a stream carries it.
google::rpc::Status to_message(const absl::Status& status);

/// The status of a message: its code, its text, and the details of the types in google/rpc/error_details.proto. Details
/// of other types are dropped.
absl::Status from_message(const google::rpc::Status& message);

/// The status that ends a unary call on a server. Its details are the serialized message of to_message.
grpc::Status to_grpc(const absl::Status& status);

/// The status that ended a unary call on a client, with the details that from_message finds. If gRPC itself refused a
/// message beyond its receive limit, that becomes INVALID_ARGUMENT, LIMIT_EXCEEDED.
absl::Status from_grpc(const grpc::Status& status);

}  // namespace segserve::wire
