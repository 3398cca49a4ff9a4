// SPDX-License-Identifier: Apache-2.0
#include "server/http/http_error.hpp"

#include <chrono>
#include <string>
#include <utility>

#include "absl/strings/escaping.h"
#include "core/base/status_text.hpp"
#include "fmt/format.h"
#include "google/protobuf/any.pb.h"
#include "google/rpc/status.pb.h"
#include "nlohmann/json.hpp"
#include "proto/wire/status_message.hpp"

namespace segserve::server {
namespace {

using Json = nlohmann::ordered_json;

/// Bytes as base64 without padding.
std::string unpadded_base64(const std::string& bytes) {
  std::string text = absl::Base64Escape(bytes);
  text.resize(text.find_last_not_of('=') + 1);
  return text;
}

HttpAnswer answer_of(const absl::Status& told, const Json& json) {
  HttpAnswer answer{.status = http_status(told), .headers = {{"Content-Type", "application/json"}}};
  if (answer.status == 401) answer.headers.emplace_back("WWW-Authenticate", "Bearer");
  if (const auto delay = wire::details_of(told).retry_delay) {
    const auto seconds = std::chrono::ceil<std::chrono::seconds>(*delay).count();
    answer.headers.emplace_back("Retry-After", fmt::format("{}", seconds));
  }
  answer.body = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  return answer;
}

}  // namespace

std::string_view connect_code(absl::StatusCode code) {
  switch (code) {
    case absl::StatusCode::kCancelled:
      return "canceled";
    case absl::StatusCode::kInvalidArgument:
      return "invalid_argument";
    case absl::StatusCode::kDeadlineExceeded:
      return "deadline_exceeded";
    case absl::StatusCode::kNotFound:
      return "not_found";
    case absl::StatusCode::kAlreadyExists:
      return "already_exists";
    case absl::StatusCode::kPermissionDenied:
      return "permission_denied";
    case absl::StatusCode::kResourceExhausted:
      return "resource_exhausted";
    case absl::StatusCode::kFailedPrecondition:
      return "failed_precondition";
    case absl::StatusCode::kAborted:
      return "aborted";
    case absl::StatusCode::kOutOfRange:
      return "out_of_range";
    case absl::StatusCode::kUnimplemented:
      return "unimplemented";
    case absl::StatusCode::kInternal:
      return "internal";
    case absl::StatusCode::kUnavailable:
      return "unavailable";
    case absl::StatusCode::kDataLoss:
      return "data_loss";
    case absl::StatusCode::kUnauthenticated:
      return "unauthenticated";
    default:
      return "unknown";
  }
}

unsigned http_status(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kOk:
      return 200;
    case absl::StatusCode::kCancelled:
      return 499;
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kFailedPrecondition:
    case absl::StatusCode::kOutOfRange:
      return 400;
    case absl::StatusCode::kUnauthenticated:
      return 401;
    case absl::StatusCode::kPermissionDenied:
      return 403;
    case absl::StatusCode::kNotFound:
      return 404;
    case absl::StatusCode::kAlreadyExists:
    case absl::StatusCode::kAborted:
      return 409;
    case absl::StatusCode::kResourceExhausted:
      return 429;
    case absl::StatusCode::kUnimplemented:
      return 501;
    case absl::StatusCode::kUnavailable:
      return 503;
    case absl::StatusCode::kDeadlineExceeded:
      return 504;
    default:
      return 500;
  }
}

HttpAnswer error_answer(const absl::Status& status) {
  const absl::Status told = wire::as_told(status);
  const wire::ErrorDetails details = wire::details_of(told);
  Json json{{"code", connect_code(told.code())}, {"reason", name(details.reason)}, {"message", message_of(told)}};
  for (const FieldViolation& fault : details.fields) {
    json["fields"].push_back({{"field", fault.field}, {"description", fault.description}});
  }
  for (const auto& [key, value] : details.metadata) json["metadata"][key] = value;
  if (details.retry_delay) json["retry_after_ms"] = details.retry_delay->count();
  HttpAnswer answer = answer_of(told, Json{{"error", json}});
  const auto limit = details.metadata.find("limit");
  const bool is_too_large = details.reason == wire::ErrorReason::kLimitExceeded && limit != details.metadata.end() &&
                            limit->second == "max_body_bytes";
  if (is_too_large) answer.status = 413;
  return answer;
}

HttpAnswer http_fault_answer(unsigned status, std::string_view message) {
  HttpAnswer answer = error_answer(wire::malformed(message));
  answer.status = status;
  answer.closes = true;
  return answer;
}

HttpAnswer connect_error_answer(const absl::Status& status) {
  const absl::Status told = wire::as_told(status);
  Json json{{"code", connect_code(told.code())}, {"message", message_of(told)}};
  const google::rpc::Status message = wire::to_message(told);
  for (const google::protobuf::Any& detail : message.details()) {
    const std::string& url = detail.type_url();
    json["details"].push_back({{"type", url.substr(url.rfind('/') + 1)}, {"value", unpadded_base64(detail.value())}});
  }
  return answer_of(told, json);
}

}  // namespace segserve::server
