// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/traces/span.hpp"

namespace segserve::server {

/// Where traces go, and what goes with them.
struct OtlpSettings {
  std::string url;                                           ///< of the collector's traces
  std::vector<std::pair<std::string, std::string>> headers;  ///< of every request; they may be secrets
  std::string ca_file;                                       ///< PEM; empty: the system's certificates
  std::vector<SpanAttribute> resource;                       ///< what this process is
};

/// OK for an URL of http or https.
absl::Status check_otlp_endpoint(const std::string& endpoint);

/// The settings for a collector at this endpoint, such as "http://127.0.0.1:4318". The environment variables of
/// OpenTelemetry give the rest: OTEL_SERVICE_NAME, OTEL_RESOURCE_ATTRIBUTES, OTEL_EXPORTER_OTLP_HEADERS and
/// OTEL_EXPORTER_OTLP_CERTIFICATE. INVALID_ARGUMENT if one of them, or the endpoint, is wrong.
absl::StatusOr<OtlpSettings> otlp_settings(const std::string& endpoint);

/// The pairs of "name=value,name=value", whose values have %XX for bytes. INVALID_ARGUMENT names the pair that is wrong
/// by its number, because values may be secrets.
absl::StatusOr<std::vector<std::pair<std::string, std::string>>> parse_pairs(std::string_view text);

}  // namespace segserve::server
