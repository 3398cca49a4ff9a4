// SPDX-License-Identifier: Apache-2.0
#include "server/http/connect_call.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "absl/strings/escaping.h"
#include "fmt/format.h"
#include "google/protobuf/util/json_util.h"
#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/slice.h"
#include "proto/wire/message_shape.hpp"
#include "proto/wire/status_message.hpp"

namespace segserve::server {
namespace {

constexpr std::array kCodecs{ConnectCodec::kProto, ConnectCodec::kJson};

/// The place of the quotation mark that ends a string of JSON, or the end of the text.
std::size_t end_of_string(std::string_view json, std::size_t begin) {
  std::size_t at = begin + 1;
  while (at < json.size() && json[at] != '"') at += json[at] == '\\' ? 2 : 1;
  return std::min(at, json.size());
}

/// Whether a string that ends there is the name of a member.
bool is_name(std::string_view json, std::size_t end) {
  const std::size_t next = json.find_first_not_of(" \t\r\n", std::min(end + 1, json.size()));
  return next != std::string_view::npos && json[next] == ':';
}

/// Says what keeps a text from being parsed: more values than a message may have, each of which but the first comes
/// after one of these characters outside of strings, or a member that an object has twice, of which the parser would
/// take the last one. Empty if there is nothing.
std::string fault_of_json(std::string_view json) {
  std::size_t values = 0;
  std::vector<std::set<std::string_view>> members;  // of the objects and arrays that have begun and not ended
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (c == '"') {
      const std::size_t end = end_of_string(json, i);
      const std::string_view text = json.substr(i + 1, end - i - 1);
      i = end;
      if (members.empty() || !is_name(json, end) || members.back().insert(text).second) continue;
      constexpr std::size_t kMostText = 64;
      return fmt::format("has an object with the member {} twice",
                         absl::CHexEscape({text.data(), std::min(text.size(), kMostText)}));
    }
    if (c == ',' || c == '[' || c == '{') {
      if (++values > wire::kMostMessageValues) return fmt::format("has more than {} values", wire::kMostMessageValues);
    }
    if (c == '[' || c == '{') members.emplace_back();
    if ((c == ']' || c == '}') && !members.empty()) members.pop_back();
  }
  return "";
}

absl::Status parse_json(const std::string& body, const char* name, google::protobuf::Message& message) {
  if (const std::string fault = fault_of_json(body); !fault.empty()) {
    return wire::malformed(fmt::format("the {} {}", name, fault));
  }
  // Unlike those of a binary message, unknown fields are refused: whoever writes JSON misspells names.
  const auto parsed = google::protobuf::util::JsonStringToMessage(body, &message);
  if (parsed.ok()) return absl::OkStatus();
  constexpr std::size_t kMostText = 200;
  const std::string text(parsed.message().data(), std::min<std::size_t>(parsed.message().size(), kMostText));
  return wire::malformed(fmt::format("the message is no {} in JSON: {}", name, text));
}

}  // namespace

std::optional<ConnectCodec> connect_codec(std::string_view type) {
  type = type.substr(0, type.find(';'));
  while (type.ends_with(' ')) type.remove_suffix(1);
  for (const ConnectCodec codec : kCodecs) {
    if (type == content_type(codec)) return codec;
  }
  return std::nullopt;
}

std::string_view content_type(ConnectCodec codec) {
  return codec == ConnectCodec::kProto ? "application/proto" : "application/json";
}

absl::StatusOr<std::optional<std::chrono::milliseconds>> connect_timeout(const HttpHead& head) {
  constexpr std::size_t kMostDigits = 10;
  std::vector<FieldViolation> faults;
  const std::string_view encoding = head.header("content-encoding");
  if (!encoding.empty() && encoding != "identity") {
    faults.push_back({"Content-Encoding", "must be identity: blocks of the payload have compressions of their own"});
  }
  const std::string_view version = head.header("connect-protocol-version");
  if (!version.empty() && version != "1") faults.push_back({"Connect-Protocol-Version", "must be 1"});
  std::optional<std::chrono::milliseconds> timeout;
  if (const std::string_view text = head.header("connect-timeout-ms"); !text.empty()) {
    std::int64_t milliseconds = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), milliseconds);
    const bool is_good =
        text.size() <= kMostDigits && error == std::errc{} && end == text.data() + text.size() && milliseconds >= 0;
    if (is_good) timeout = std::chrono::milliseconds(milliseconds);
    if (!is_good) faults.push_back({"Connect-Timeout-Ms", "must be a whole number of at most 10 digits"});
  }
  if (absl::Status status = wire::invalid_fields(faults); !status.ok()) return status;
  return timeout;
}

absl::Status parse_connect(ConnectCodec codec, std::string body, const char* name, google::protobuf::Message& message) {
  if (codec == ConnectCodec::kJson) return parse_json(body, name, message);
  const grpc::Slice slice(body);
  body = std::string();
  grpc::ByteBuffer bytes(&slice, 1);
  return wire::parse_bounded(bytes, name, message);
}

std::uint64_t parsing_bytes(ConnectCodec codec, std::uint64_t body_bytes) {
  // JSON is turned into a binary message first.
  return body_bytes * (codec == ConnectCodec::kJson ? 3 : 2);
}

absl::StatusOr<HttpAnswer> connect_answer(ConnectCodec codec, const google::protobuf::Message& message) {
  HttpAnswer answer{.status = 200, .headers = {{"Content-Type", std::string(content_type(codec))}}};
  const bool written = codec == ConnectCodec::kProto
                           ? message.SerializeToString(&answer.body)
                           : google::protobuf::util::MessageToJsonString(message, &answer.body).ok();
  if (!written) return absl::InternalError("the answer cannot be serialized");
  return answer;
}

}  // namespace segserve::server
