// SPDX-License-Identifier: Apache-2.0
#include "server/traces/otlp_settings.hpp"

#include <curl/curl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdlib>
#include <memory>
#include <optional>

#include "absl/strings/ascii.h"
#include "absl/strings/str_split.h"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "fmt/format.h"
#include "proto/wire/traceparent.hpp"
#include "server/version.hpp"

namespace segserve::server {
namespace {

using Pairs = std::vector<std::pair<std::string, std::string>>;

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

std::string trimmed(absl::string_view text) { return std::string(absl::StripAsciiWhitespace(text)); }

std::optional<std::string> without_percents(const std::string& text) {
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      decoded += text[i];
      continue;
    }
    unsigned byte = 0;
    const char* begin = text.data() + std::min(i + 1, text.size());
    const char* end = text.data() + std::min(i + 3, text.size());
    if (end - begin != 2 || std::from_chars(begin, end, byte, 16).ptr != end) return std::nullopt;
    decoded += static_cast<char>(byte);
    i += 2;
  }
  return decoded;
}

absl::StatusOr<Pairs> pairs_of(const char* variable) {
  absl::StatusOr<Pairs> pairs = parse_pairs(environment(variable));
  if (!pairs.ok()) return with_prefix(variable, pairs.status());
  return pairs;
}

/// A name or value that could end the header's line would be another header.
bool is_header(const std::pair<std::string, std::string>& header) {
  const auto is_token = [](char c) { return absl::ascii_isalnum(c) || c == '-' || c == '_' || c == '.'; };
  return std::ranges::all_of(header.first, is_token) &&
         std::ranges::none_of(header.second, [](char c) { return absl::ascii_iscntrl(c); });
}

void set_attribute(const std::string& key, std::string value, std::vector<SpanAttribute>& attributes) {
  const auto found = std::ranges::find(attributes, key, &SpanAttribute::key);
  if (found != attributes.end()) {
    found->value = std::move(value);
  } else {
    attributes.push_back({key, std::move(value)});
  }
}

absl::StatusOr<std::vector<SpanAttribute>> resource() {
  std::array<char, 256> host{};
  gethostname(host.data(), host.size() - 1);
  std::vector<SpanAttribute> attributes = {{"service.name", "segserve"},
                                           {"service.version", kVersion},
                                           {"service.instance.id", wire::new_trace_id()},
                                           {"host.name", host.data()},
                                           {"process.pid", std::int64_t{getpid()}},
                                           {"telemetry.sdk.name", "segserve"},
                                           {"telemetry.sdk.language", "cpp"},
                                           {"telemetry.sdk.version", kVersion}};
  ASSIGN_OR_RETURN(const Pairs given, pairs_of("OTEL_RESOURCE_ATTRIBUTES"));
  for (const auto& [key, value] : given) set_attribute(key, value, attributes);
  const std::string name = environment("OTEL_SERVICE_NAME");
  if (!name.empty()) set_attribute("service.name", name, attributes);
  return attributes;
}

}  // namespace

absl::Status check_otlp_endpoint(const std::string& endpoint) {
  const std::unique_ptr<CURLU, decltype(&curl_url_cleanup)> url(curl_url(), curl_url_cleanup);
  // Names and passwords in it are refused, because command lines and logs are no place for them.
  const bool is_url = url && curl_url_set(url.get(), CURLUPART_URL, endpoint.c_str(), CURLU_DISALLOW_USER) == CURLUE_OK;
  if (is_url && (endpoint.starts_with("http://") || endpoint.starts_with("https://"))) return absl::OkStatus();
  return absl::InvalidArgumentError(
      "it must be an URL of http or https without a user, such as http://127.0.0.1:4318; secrets go into "
      "OTEL_EXPORTER_OTLP_HEADERS");
}

absl::StatusOr<OtlpSettings> otlp_settings(const std::string& endpoint) {
  RETURN_IF_ERROR(check_otlp_endpoint(endpoint));
  OtlpSettings settings;
  settings.url = fmt::format("{}{}v1/traces", endpoint, endpoint.ends_with('/') ? "" : "/");
  ASSIGN_OR_RETURN(settings.headers, pairs_of("OTEL_EXPORTER_OTLP_HEADERS"));
  if (!std::ranges::all_of(settings.headers, is_header)) {
    return absl::InvalidArgumentError("OTEL_EXPORTER_OTLP_HEADERS: a name or value cannot be that of a header");
  }
  settings.ca_file = environment("OTEL_EXPORTER_OTLP_CERTIFICATE");
  ASSIGN_OR_RETURN(settings.resource, resource());
  return settings;
}

absl::StatusOr<Pairs> parse_pairs(std::string_view text) {
  Pairs pairs;
  std::size_t number = 0;
  for (const absl::string_view part : absl::StrSplit(absl::string_view(text.data(), text.size()), ',')) {
    ++number;
    const std::string pair = trimmed(part);
    if (pair.empty()) continue;
    const std::size_t equals = pair.find('=');
    const std::string name = trimmed(pair.substr(0, equals));
    const auto value = equals == std::string::npos ? std::nullopt : without_percents(trimmed(pair.substr(equals + 1)));
    if (name.empty() || !value) {
      return absl::InvalidArgumentError(fmt::format("part {} is not of the form name=value", number));
    }
    pairs.emplace_back(name, *value);
  }
  return pairs;
}

}  // namespace segserve::server
