// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/metrics_page.hpp"

#include <array>
#include <cstddef>

#include "client/tls/timed_socket.hpp"
#include "core/base/status_macros.hpp"
#include "fmt/format.h"

namespace segserve::bench {
namespace {

constexpr std::size_t kMostPageBytes = std::size_t{16} << 20U;

absl::Status unavailable(const MetricsAddress& address, std::string_view why) {
  return absl::UnavailableError(
      fmt::format("no metrics from {}:{}{}: {}", address.host, address.port, address.path, why));
}

/// Everything that the server sends until it closes the connection.
absl::StatusOr<std::string> http_get(const MetricsAddress& address, std::chrono::milliseconds timeout) {
  client::TimedSocket socket(timeout);
  if (!socket.connect(address.host, address.port)) return unavailable(address, "nobody takes the connection");
  // By version 1.0 the answer comes in one piece, and its end is that of the connection.
  const std::string request = fmt::format("GET {} HTTP/1.0\r\nHost: {}:{}\r\nAccept: text/plain\r\n\r\n", address.path,
                                          address.host, address.port);
  if (!socket.send(request)) return unavailable(address, "the connection broke");
  std::string answer;
  std::array<char, 16384> buffer{};
  while (true) {
    const auto count = socket.receive(buffer);
    if (!count) return unavailable(address, "the time is over");
    if (*count == 0) return answer;
    answer.append(buffer.data(), *count);
    if (answer.size() > kMostPageBytes) return unavailable(address, "the page has more than 16 MiB");
  }
}

}  // namespace

absl::StatusOr<MetricsAddress> parse_metrics_address(std::string_view text) {
  constexpr std::string_view kScheme = "http://";
  const auto wrong = [whole = std::string(text)] {
    return absl::InvalidArgumentError(fmt::format("'{}' must be http://HOST:PORT/metrics or HOST:PORT", whole));
  };
  if (text.starts_with(kScheme)) text.remove_prefix(kScheme.size());
  MetricsAddress address;
  const std::size_t slash = text.find('/');
  address.path = slash == std::string_view::npos ? "/metrics" : std::string(text.substr(slash));
  const std::string_view place = text.substr(0, slash);
  const std::size_t colon = place.rfind(':');
  if (colon == std::string_view::npos) return wrong();
  std::string_view host = place.substr(0, colon);
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  address.host = host;
  address.port = place.substr(colon + 1);
  const bool is_number = !address.port.empty() && address.port.find_first_not_of("0123456789") == std::string::npos;
  const bool is_clean = address.path.find_first_of(" \r\n") == std::string::npos;
  if (address.host.empty() || !is_number || !is_clean) return wrong();
  return address;
}

absl::StatusOr<std::vector<MetricSample>> read_metrics(const MetricsAddress& address,
                                                       std::chrono::milliseconds timeout) {
  ASSIGN_OR_RETURN(const std::string answer, http_get(address, timeout));
  const std::size_t body = answer.find("\r\n\r\n");
  const std::string_view status = std::string_view(answer).substr(0, answer.find("\r\n"));
  if (body == std::string::npos || !status.starts_with("HTTP/1.")) return unavailable(address, "that is no HTTP");
  if (status.find(" 200") == std::string_view::npos) return unavailable(address, status);
  std::vector<MetricSample> samples = parse_prometheus_text(std::string_view(answer).substr(body + 4));
  if (samples.empty()) return unavailable(address, "the page holds none");
  return samples;
}

}  // namespace segserve::bench
