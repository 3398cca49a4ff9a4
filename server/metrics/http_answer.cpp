// SPDX-License-Identifier: Apache-2.0
#include "server/metrics/http_answer.hpp"

#include "fmt/format.h"

namespace segserve::server {
namespace {

constexpr std::string_view kPath = "/metrics";
constexpr std::string_view kText = "text/plain; charset=utf-8";
constexpr std::string_view kMetricsText = "text/plain; version=0.0.4; charset=utf-8";

std::string answer(std::string_view status, std::string_view type, std::string_view body, bool with_body = true) {
  return fmt::format(
      "HTTP/1.1 {}\r\nContent-Type: {}\r\nContent-Length: {}\r\nCache-Control: no-store\r\nConnection: close\r\n\r\n{}",
      status, type, body.size(), with_body ? body : "");
}

std::string error(std::string_view status) { return answer(status, kText, fmt::format("{}\n", status)); }

/// Takes the text before the first space out of `line`.
std::string_view take_word(std::string_view& line) {
  const std::size_t end = line.find(' ');
  const std::string_view word = line.substr(0, end);
  line.remove_prefix(end == std::string_view::npos ? line.size() : end + 1);
  return word;
}

}  // namespace

std::optional<std::string> http_answer(std::string_view received,
                                       const std::function<std::optional<std::string>()>& page) {
  if (received.find("\r\n\r\n") == std::string_view::npos) {
    if (received.size() < kMostRequestBytes) return std::nullopt;
    return error("431 Request Header Fields Too Large");
  }
  std::string_view line = received.substr(0, received.find("\r\n"));
  const std::string_view method = take_word(line);
  std::string_view target = take_word(line);
  if (!line.starts_with("HTTP/1.")) return error("400 Bad Request");
  target = target.substr(0, target.find('?'));
  if (target != kPath) return error("404 Not Found");
  if (method != "GET" && method != "HEAD") return error("405 Method Not Allowed");
  const std::optional<std::string> body = page();
  if (!body) return error("429 Too Many Requests");
  return answer("200 OK", kMetricsText, *body, method == "GET");
}

}  // namespace segserve::server
