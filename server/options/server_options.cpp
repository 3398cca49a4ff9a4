// SPDX-License-Identifier: Apache-2.0
#include "server/options/server_options.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "absl/status/statusor.h"
#include "fmt/format.h"
#include "proto/wire/transport_limits.hpp"
#include "server/options/host_name.hpp"
#include "server/options/listen_address.hpp"

namespace segserve::server {
namespace {

template <typename Value>
void check_range(const char* flag, Value value, Value minimum, Value maximum, std::vector<FieldViolation>& faults) {
  if (value < minimum || value > maximum) {
    faults.push_back({flag, fmt::format("{} is not in [{}, {}]", value, minimum, maximum)});
  }
}

std::string beyond_loopback(const std::string& address) {
  return fmt::format(
      "{} can be reached by other machines, and the connection is not encrypted; --tls-cert and --tls-key "
      "encrypt it, --insecure-beyond-loopback allows plain text",
      address);
}

/// Whether a text is SCHEME://HOST or SCHEME://HOST:PORT of the web.
bool is_web_origin(std::string_view text) {
  for (const std::string_view scheme : {"https://", "http://"}) {
    if (!text.starts_with(scheme)) continue;
    text.remove_prefix(scheme.size());
    const auto belongs = [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
             std::string_view(".-:[]_").find(c) != std::string_view::npos;
    };
    return !text.empty() && std::ranges::all_of(text, belongs);
  }
  return false;
}

void check_listen(const ServerOptions& options, std::vector<FieldViolation>& faults) {
  const absl::StatusOr<ListenAddress> address = parse_listen_address(options.listen);
  if (!address.ok()) {
    faults.push_back({"listen", std::string(address.status().message())});
  } else if (address->is_unix && !options.tls_cert.empty()) {
    faults.push_back(
        {"tls-cert",
         fmt::format("{} is a unix socket, which has no TLS; leave out --tls-cert, --tls-key and --tls-client-ca",
                     options.listen)});
  } else if (!address->is_loopback() && options.tls_cert.empty() && !options.insecure_beyond_loopback) {
    faults.push_back({"listen", beyond_loopback(options.listen)});
  }
}

void check_health_listen(const ServerOptions& options, std::vector<FieldViolation>& faults) {
  if (options.health_listen.empty()) return;
  const absl::StatusOr<ListenAddress> address = parse_listen_address(options.health_listen);
  if (!address.ok()) faults.push_back({"health-listen", std::string(address.status().message())});
}

void check_http(const ServerOptions& options, std::vector<FieldViolation>& faults) {
  if (options.http.empty()) {
    if (!options.http_allow_origin.empty()) faults.push_back({"http-allow-origin", "it needs --http, too"});
    if (!options.http_host.empty()) faults.push_back({"http-host", "it needs --http, too"});
    return;
  }
  const absl::StatusOr<ListenAddress> address = parse_listen_address(options.http);
  if (!address.ok()) {
    faults.push_back({"http", std::string(address.status().message())});
  } else if (address->is_unix) {
    faults.push_back({"http", "the web entrance is not served on a unix socket; give HOST:PORT"});
  } else if (!address->is_loopback() && options.tls_cert.empty() && !options.insecure_beyond_loopback) {
    faults.push_back({"http", beyond_loopback(options.http)});
  }
  if (const auto names = parse_host_names(options.http_host); !names.ok()) {
    faults.push_back({"http-host", std::string(names.status().message())});
  }
  const std::string& origin = options.http_allow_origin;
  const bool is_origin = origin.empty() || origin == "*" || is_web_origin(origin);
  if (!is_origin) {
    faults.push_back(
        {"http-allow-origin", fmt::format("'{}' must be *, or an origin such as https://app.example:8443", origin)});
  }
}

void check_tls(const ServerOptions& options, std::vector<FieldViolation>& faults) {
  if (options.tls_cert.empty() != options.tls_key.empty()) {
    const bool has_key = options.tls_cert.empty();
    faults.push_back(
        {has_key ? "tls-key" : "tls-cert", fmt::format("it needs --{}, too", has_key ? "tls-cert" : "tls-key")});
  } else if (!options.tls_client_ca.empty() && options.tls_cert.empty()) {
    faults.push_back({"tls-client-ca", "it needs --tls-cert and --tls-key, too"});
  }
}

void check_access(const ServerOptions& options, std::vector<FieldViolation>& faults) {
  const bool has_keys = !options.jwt_keys.empty();
  for (const auto& [flag, value] :
       {std::pair("jwt-issuer", &options.jwt_issuer), std::pair("jwt-audience", &options.jwt_audience)}) {
    if (has_keys && value->empty()) faults.push_back({flag, "--jwt-keys needs it, so that others are refused"});
    if (!has_keys && !value->empty()) faults.push_back({flag, "it needs --jwt-keys, too"});
  }
  const bool asks_for_tokens = has_keys || !options.tokens.empty();
  for (const std::string* const listen : {&options.listen, &options.http}) {
    const absl::StatusOr<ListenAddress> address = parse_listen_address(*listen);
    const bool is_open = address.ok() && !address->is_loopback() && options.tls_cert.empty();
    if (!asks_for_tokens || !is_open || options.insecure_tokens) continue;
    faults.push_back({has_keys ? "jwt-keys" : "tokens",
                      fmt::format("{} can be reached by other machines, and whoever listens in could use the tokens, "
                                  "which are not encrypted; --tls-cert and --tls-key encrypt them, --insecure-tokens "
                                  "allows plain text",
                                  *listen)});
  }
}

void check_metrics_listen(const ServerOptions& options, std::vector<FieldViolation>& faults) {
  if (options.metrics_listen.empty()) return;
  const absl::StatusOr<ListenAddress> address = parse_listen_address(options.metrics_listen);
  if (!address.ok()) {
    faults.push_back({"metrics-listen", std::string(address.status().message())});
  } else if (address->is_unix) {
    faults.push_back({"metrics-listen", "metrics are not served on a unix socket; give HOST:PORT"});
  }
}

/// Two servers of one process cannot have one address.
void check_differences(const ServerOptions& options, std::vector<FieldViolation>& faults) {
  const std::array addresses{std::pair("listen", &options.listen), std::pair("health-listen", &options.health_listen),
                             std::pair("metrics-listen", &options.metrics_listen), std::pair("http", &options.http)};
  for (std::size_t i = 1; i < addresses.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const auto [flag, address] = addresses[i];
      if (address->empty() || address->ends_with(":0") || *address != *addresses[j].second) continue;
      faults.push_back({flag, fmt::format("{} is the address of --{}, too", *address, addresses[j].first)});
    }
  }
}

}  // namespace

std::vector<FieldViolation> violations(const ServerOptions& options) {
  constexpr std::uint64_t kPetabyte = std::uint64_t{1} << 50U, kTerabyte = std::uint64_t{1} << 40U;
  constexpr std::uint64_t kLeastMemory = std::uint64_t{64} << 20U;
  constexpr std::int64_t kDayMs = 86'400'000;
  std::vector<FieldViolation> faults;
  check_listen(options, faults);
  check_health_listen(options, faults);
  check_tls(options, faults);
  check_access(options, faults);
  check_metrics_listen(options, faults);
  check_http(options, faults);
  check_differences(options, faults);
  check_range<std::size_t>("workers", options.workers, 0, 1024, faults);
  check_range<std::uint32_t>("threads", options.threads, 1, 64, faults);
  check_range<std::size_t>("queue", options.queue, 1, 100'000, faults);
  check_range<std::uint64_t>("queue-bytes", options.queue_bytes,
                             std::max(options.max_decoded_bytes, wire::kMaxRequestBytes), kPetabyte, faults);
  check_range<std::uint64_t>("queue-points", options.queue_points, options.max_points, kPetabyte, faults);
  check_range<std::uint32_t>("stream-frames", options.stream_frames, 1, 1024, faults);
  check_range<std::uint64_t>("stream-bytes", options.stream_bytes, 1, kTerabyte, faults);
  check_range<std::uint64_t>("max-points", options.max_points, 1, 1'000'000'000, faults);
  check_range<std::uint64_t>("max-decoded-bytes", options.max_decoded_bytes, 1, kTerabyte, faults);
  check_range<std::uint64_t>("max-voxels", options.max_voxels, 1, 1'000'000'000, faults);
  if (options.memory != 0) check_range<std::uint64_t>("memory", options.memory, kLeastMemory, kPetabyte, faults);
  check_range<std::int64_t>("max-frame-seconds", options.max_frame_time.count(), 1, kDayMs, faults);
  check_range<std::int64_t>("grace-period", options.grace_period.count(), 0, kDayMs, faults);
  check_range<std::int64_t>("max-stream-age", options.max_stream_age.count(), 0, kDayMs, faults);
  check_range<std::int64_t>("ping-interval", options.ping_interval.count(), 0, kDayMs, faults);
  check_range<std::int64_t>("drain-delay", options.drain_delay.count(), 0, kDayMs, faults);
  for (FieldViolation& fault : segserve::violations(options.defaults)) faults.push_back(std::move(fault));
  return faults;
}

}  // namespace segserve::server
