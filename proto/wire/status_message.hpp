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

// The one place where results of core become gRPC's and back. An absl::Status carries its details as
// payloads (google.rpc messages under their Any type URLs), so that nothing is lost on the way.
namespace segserve::wire {

/// The status with these details; those it had are replaced. OK statuses stay as they are.
absl::Status with_details(absl::Status status, const ErrorDetails& details);

/// The status with this reason, unless it is OK or has one already.
absl::Status with_reason(absl::Status status, ErrorReason reason);

/// INVALID_ARGUMENT, reason MALFORMED_PAYLOAD: bytes that are not what they claim to be.
absl::Status malformed(std::string_view message);

/// INVALID_ARGUMENT, INVALID_FIELD, with a message that lists every wrong field; OK if there is none.
absl::Status invalid_fields(const std::vector<FieldViolation>& fields);

/// INVALID_ARGUMENT, LIMIT_EXCEEDED: "the cloud has 7 points, more than max_points = 5". `subject` is
/// "the cloud has", `unit` "points", `limit` the field of v1.Limits.
absl::Status limit_exceeded(std::string_view subject, std::uint64_t actual, std::string_view unit,
                            std::string_view limit, std::uint64_t allowed);

/// The status with its details, as a stream carries it. A status without a reason gets the one that its code implies;
/// a code that the API does not list becomes INTERNAL.
google::rpc::Status to_message(const absl::Status& status);

/// The code, the message and every detail we know; foreign details are dropped.
absl::Status from_message(const google::rpc::Status& message);

/// For a server's unary call: to_message, serialized, as the details of gRPC's status.
grpc::Status to_grpc(const absl::Status& status);

/// For a client's: the code, the message and what from_message finds in the details. gRPC's own refusal of a message
/// beyond its receive limit becomes INVALID_ARGUMENT, LIMIT_EXCEEDED.
absl::Status from_grpc(const grpc::Status& status);

}  // namespace segserve::wire
