// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/status_message.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "absl/strings/cord.h"
#include "fmt/format.h"
#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"

namespace segserve::wire {
namespace {

constexpr std::string_view kDomain = "segserve";
constexpr std::string_view kAnyPrefix = "type.googleapis.com/";

// The names are in the order of the enum.
constexpr std::array<std::string_view, 17> kReasonNames{
    "UNSPECIFIED",        "INVALID_FIELD",     "MALFORMED_PAYLOAD", "INVALID_CLOUD", "LIMIT_EXCEEDED", "QUEUE_FULL",
    "DRAINING",           "DEADLINE_EXCEEDED", "CANCELLED",         "INTERNAL",      "CHECKSUM",       "UPLOAD_STALLED",
    "PROTOCOL_VIOLATION", "TOKEN_MISSING",     "TOKEN_INVALID",     "TOKEN_EXPIRED", "QUOTA_EXCEEDED"};

/// The type URL of a kind of detail. Both google.protobuf.Any and absl::Status keep details under it.
template <typename Message>
std::string type_url() {
  return std::string(kAnyPrefix) + Message::descriptor()->full_name();
}

template <typename Message>
void put(absl::Status& status, const Message& message) {
  status.SetPayload(type_url<Message>(), absl::Cord(message.SerializeAsString()));
}

template <typename Message>
std::optional<Message> get(const absl::Status& status) {
  const absl::optional<absl::Cord> bytes = status.GetPayload(type_url<Message>());
  Message message;
  if (!bytes || !message.ParseFromString(std::string(*bytes))) return std::nullopt;
  return message;
}

template <typename Message>
void copy_detail(const google::rpc::Status& from, absl::Status& to) {
  for (const google::protobuf::Any& detail : from.details()) {
    if (Message message; detail.UnpackTo(&message)) put(to, message);
  }
}

/// The reason that a code implies. INVALID_ARGUMENT implies none, because several reasons share it.
ErrorReason implied_reason(absl::StatusCode code) {
  switch (code) {
    case absl::StatusCode::kInvalidArgument:
      return ErrorReason::kUnspecified;
    case absl::StatusCode::kResourceExhausted:
      return ErrorReason::kQueueFull;
    case absl::StatusCode::kUnavailable:
      return ErrorReason::kDraining;
    case absl::StatusCode::kDeadlineExceeded:
      return ErrorReason::kDeadlineExceeded;
    case absl::StatusCode::kCancelled:
      return ErrorReason::kCancelled;
    case absl::StatusCode::kAborted:
      return ErrorReason::kChecksum;
    case absl::StatusCode::kUnauthenticated:
      return ErrorReason::kTokenInvalid;
    default:
      return ErrorReason::kInternal;
  }
}

bool is_in_api(absl::StatusCode code) {
  return code == absl::StatusCode::kInvalidArgument || implied_reason(code) != ErrorReason::kInternal;
}

ErrorReason reason_from_name(std::string_view name) {
  const auto* found = std::ranges::find(kReasonNames, name);
  if (found == kReasonNames.end()) return ErrorReason::kUnspecified;
  return static_cast<ErrorReason>(found - kReasonNames.begin());
}

/// The delay, limited to the range from 0 to one day.
std::chrono::milliseconds read_retry_delay(const google::protobuf::Duration& message) {
  constexpr std::int64_t kDay = std::int64_t{24} * 60 * 60;
  const std::int64_t seconds = std::clamp(message.seconds(), -kDay, kDay);
  const std::int64_t milliseconds = seconds * 1000 + message.nanos() / 1'000'000;
  return std::chrono::milliseconds(std::clamp(milliseconds, std::int64_t{0}, kDay * 1000));
}

/// Whether gRPC refused a message beyond the receive limit, with the text "Received message larger than max (9 vs. 8)".
bool is_message_too_large(const grpc::Status& status) {
  return status.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED && status.error_details().empty() &&
         status.error_message().find("larger than max") != std::string::npos;
}

}  // namespace

std::string_view name(ErrorReason reason) { return kReasonNames[static_cast<std::size_t>(reason)]; }

absl::Status with_details(absl::Status status, const ErrorDetails& details) {
  if (status.ok()) return status;
  google::rpc::ErrorInfo info;
  info.set_reason(std::string(name(details.reason)));
  info.set_domain(std::string(kDomain));
  info.mutable_metadata()->insert(details.metadata.begin(), details.metadata.end());
  put(status, info);

  status.ErasePayload(type_url<google::rpc::BadRequest>());
  if (!details.fields.empty()) {
    google::rpc::BadRequest bad_request;
    for (const FieldViolation& fault : details.fields) {
      auto* violation = bad_request.add_field_violations();
      violation->set_field(fault.field);
      violation->set_description(fault.description);
    }
    put(status, bad_request);
  }

  status.ErasePayload(type_url<google::rpc::QuotaFailure>());
  if (!details.quotas.empty()) {
    google::rpc::QuotaFailure failure;
    for (const QuotaViolation& quota : details.quotas) {
      auto* violation = failure.add_violations();
      violation->set_subject(quota.subject);
      violation->set_description(quota.description);
    }
    put(status, failure);
  }

  status.ErasePayload(type_url<google::rpc::RetryInfo>());
  if (details.retry_delay) {
    google::rpc::RetryInfo retry;
    const std::int64_t milliseconds = details.retry_delay->count();
    retry.mutable_retry_delay()->set_seconds(milliseconds / 1000);
    retry.mutable_retry_delay()->set_nanos(static_cast<std::int32_t>(milliseconds % 1000 * 1'000'000));
    put(status, retry);
  }
  return status;
}

absl::Status with_reason(absl::Status status, ErrorReason reason) {
  if (status.ok() || get<google::rpc::ErrorInfo>(status)) return status;
  ErrorDetails details = details_of(status);
  details.reason = reason;
  return with_details(std::move(status), details);
}

ErrorDetails details_of(const absl::Status& status) {
  ErrorDetails details;
  if (const auto info = get<google::rpc::ErrorInfo>(status); info && info->domain() == kDomain) {
    details.reason = reason_from_name(info->reason());
    details.metadata = {info->metadata().begin(), info->metadata().end()};
  }
  if (const auto bad_request = get<google::rpc::BadRequest>(status)) {
    for (const auto& violation : bad_request->field_violations()) {
      details.fields.push_back({violation.field(), violation.description()});
    }
  }
  if (const auto failure = get<google::rpc::QuotaFailure>(status)) {
    for (const auto& violation : failure->violations()) {
      details.quotas.push_back({violation.subject(), violation.description()});
    }
  }
  if (const auto retry = get<google::rpc::RetryInfo>(status)) {
    details.retry_delay = read_retry_delay(retry->retry_delay());
  }
  return details;
}

absl::Status malformed(std::string_view message) {
  return with_reason(absl::InvalidArgumentError(std::string(message)), ErrorReason::kMalformedPayload);
}

absl::Status malformed(std::string_view name, const absl::Status& cause) {
  return malformed(fmt::format("{}: {}", name, std::string(cause.message())));
}

absl::Status invalid_fields(const std::vector<FieldViolation>& fields) {
  if (fields.empty()) return absl::OkStatus();
  std::string message;
  for (const FieldViolation& fault : fields) {
    fmt::format_to(std::back_inserter(message), "{}{}: {}", message.empty() ? "" : "; ", fault.field,
                   fault.description);
  }
  return with_details(absl::InvalidArgumentError(message), {.reason = ErrorReason::kInvalidField, .fields = fields});
}

absl::Status limit_exceeded(std::string_view subject, std::uint64_t actual, std::string_view unit,
                            std::string_view limit, std::uint64_t allowed) {
  return with_details(
      absl::InvalidArgumentError(fmt::format("{} {} {}, more than {} = {}", subject, actual, unit, limit, allowed)),
      {.reason = ErrorReason::kLimitExceeded,
       .metadata = {{"limit", std::string(limit)},
                    {"allowed", fmt::format("{}", allowed)},
                    {"actual", fmt::format("{}", actual)}}});
}

absl::Status as_told(const absl::Status& status) {
  if (status.ok()) return status;
  const absl::StatusCode code = is_in_api(status.code()) ? status.code() : absl::StatusCode::kInternal;
  absl::Status told(code, status.message());
  status.ForEachPayload([&told](absl::string_view url, const absl::Cord& bytes) { told.SetPayload(url, bytes); });
  return with_reason(std::move(told), implied_reason(code));
}

google::rpc::Status to_message(const absl::Status& status) {
  google::rpc::Status message;
  if (status.ok()) return message;
  const absl::Status told = as_told(status);
  message.set_code(static_cast<int>(told.code()));
  message.set_message(std::string(told.message()));
  told.ForEachPayload([&message](absl::string_view url, const absl::Cord& bytes) {
    google::protobuf::Any* detail = message.add_details();
    detail->set_type_url(std::string(url));
    detail->set_value(std::string(bytes));
  });
  return message;
}

absl::Status from_message(const google::rpc::Status& message) {
  absl::Status result(static_cast<absl::StatusCode>(message.code()), message.message());
  copy_detail<google::rpc::ErrorInfo>(message, result);
  copy_detail<google::rpc::BadRequest>(message, result);
  copy_detail<google::rpc::RetryInfo>(message, result);
  copy_detail<google::rpc::QuotaFailure>(message, result);
  copy_detail<google::rpc::RequestInfo>(message, result);
  return result;
}

grpc::Status to_grpc(const absl::Status& status) {
  if (status.ok()) return grpc::Status::OK;
  const google::rpc::Status message = to_message(status);
  return {static_cast<grpc::StatusCode>(message.code()), message.message(), message.SerializeAsString()};
}

absl::Status from_grpc(const grpc::Status& status) {
  if (status.ok()) return absl::OkStatus();
  if (is_message_too_large(status)) {
    return with_details(
        absl::InvalidArgumentError("the message exceeds the receiver's limit: " + status.error_message()),
        {.reason = ErrorReason::kLimitExceeded, .metadata = {{"limit", "max_message_bytes"}}});
  }
  google::rpc::Status message;
  if (!message.ParseFromString(status.error_details())) message.Clear();
  message.set_code(static_cast<int>(status.error_code()));
  message.set_message(status.error_message());
  return from_message(message);
}

}  // namespace segserve::wire
