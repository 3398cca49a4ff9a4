// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/http_listener.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "core/base/loopback_host.hpp"
#include "core/base/status_macros.hpp"
#include "fmt/format.h"

namespace segserve::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kLook{100};
constexpr std::chrono::milliseconds kReadTime{5000};
constexpr std::size_t kMostHeadBytes = 16384;
constexpr std::size_t kMostConnections = 16;

/// The lines before the first empty one; nullopt if they do not come in time, or are too long.
std::optional<std::vector<std::string>> read_head(LineSocket& browser) {
  const auto until = Clock::now() + kReadTime;
  std::vector<std::string> lines;
  std::size_t bytes = 0;
  while (bytes < kMostHeadBytes) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now());
    auto line = browser.receive(std::max(left, std::chrono::milliseconds(0)), kMostHeadBytes);
    if (!line.ok() || !*line) return std::nullopt;
    if ((*line)->ends_with('\r')) (*line)->pop_back();
    if ((*line)->empty()) return lines;
    bytes += (*line)->size() + 1;
    lines.push_back(*std::move(*line));
  }
  return std::nullopt;
}

std::string_view without_spaces(std::string_view text) {
  while (text.starts_with(' ') || text.starts_with('\t')) text.remove_prefix(1);
  while (text.ends_with(' ') || text.ends_with('\t')) text.remove_suffix(1);
  return text;
}

/// The values of a header, whose name is given in small letters with its colon.
std::vector<std::string_view> values_of(const std::vector<std::string>& head, std::string_view name) {
  std::vector<std::string_view> values;
  for (std::size_t i = 1; i < head.size(); ++i) {
    if (absl::StartsWithIgnoreCase(head[i], {name.data(), name.size()})) {
      values.push_back(without_spaces(std::string_view(head[i]).substr(name.size())));
    }
  }
  return values;
}

/// Whether a header Host, with or without a port, names this machine.
bool names_loopback(std::string_view host) {
  const std::size_t bracket = host.find(']');
  const std::size_t colon = host.find(':', bracket == std::string_view::npos ? 0 : bracket);
  if (colon != std::string_view::npos && host.find_first_not_of("0123456789", colon + 1) != std::string_view::npos) {
    return false;
  }
  host = host.substr(0, colon);
  if (host.starts_with('[') && host.ends_with(']'))
    return is_loopback_host(std::string(host.substr(1, host.size() - 2)));
  return is_loopback_host(std::string(host));
}

HttpReply short_reply(std::string status, std::string text) {
  HttpReply reply;
  reply.status = std::move(status);
  reply.body = std::make_shared<const std::string>(std::move(text) + "\n");
  return reply;
}

std::string header_of(const HttpReply& reply) {
  return fmt::format(
      "HTTP/1.1 {}\r\nContent-Type: {}\r\nContent-Length: {}\r\nContent-Security-Policy: {}\r\n"
      "X-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\nCross-Origin-Opener-Policy: same-origin\r\n"
      "Cross-Origin-Resource-Policy: same-origin\r\nCache-Control: no-store\r\nConnection: close\r\n\r\n",
      reply.status, reply.content_type, reply.body ? reply.body->size() : 0, reply.policy);
}

/// The request of a first line "GET TARGET HTTP/1.x"; nullopt for anything else.
std::optional<HttpRequest> parse_request(std::string_view line) {
  constexpr std::string_view kMethod = "GET ";
  if (!line.starts_with(kMethod)) return std::nullopt;
  line.remove_prefix(kMethod.size());
  const std::size_t end = line.find(" HTTP/1.");
  if (end == std::string_view::npos || !line.starts_with('/')) return std::nullopt;
  line = line.substr(0, end);
  const std::size_t mark = std::min(line.find('?'), line.size());
  return HttpRequest{std::string(line.substr(0, mark)), std::string(line.substr(std::min(mark + 1, line.size())))};
}

}  // namespace

absl::StatusOr<std::unique_ptr<HttpListener>> HttpListener::start(const std::string& host, const std::string& port,
                                                                  Handler handler) {
  ASSIGN_OR_RETURN(auto listener, LineListener::listen(host, port));
  return std::unique_ptr<HttpListener>(
      new HttpListener(std::move(listener), is_loopback_host(host), std::move(handler)));
}

HttpListener::HttpListener(LineListener listener, bool only_loopback, Handler handler)
    : listener_(std::move(listener)),
      only_loopback_(only_loopback),
      handler_(std::move(handler)),
      thread_([this] { run(); }) {}

HttpListener::~HttpListener() {
  stopping_ = true;
  thread_.join();
}

void HttpListener::join_done() {
  std::erase_if(connections_, [](Connection& connection) {
    if (!connection.is_done) return false;
    connection.thread.join();
    return true;
  });
}

void HttpListener::run() {
  while (!stopping_) {
    auto browser = listener_.accept(kLook);
    join_done();
    if (!browser || connections_.size() >= kMostConnections) continue;  // What is not taken is closed.
    Connection& connection = connections_.emplace_back();
    connection.thread = std::thread([this, &connection, socket = *std::move(browser)]() mutable {
      serve(socket);
      connection.is_done = true;
    });
  }
  for (Connection& connection : connections_) connection.thread.join();
}

void HttpListener::serve(LineSocket& browser) const {
  const auto head = read_head(browser);
  if (!head || head->empty()) return;
  const auto request = parse_request(head->front());
  const auto hosts = values_of(*head, "host:");
  const auto lengths = values_of(*head, "content-length:");
  const bool has_body = std::ranges::any_of(lengths, [](std::string_view length) { return length != "0"; }) ||
                        !values_of(*head, "transfer-encoding:").empty();
  HttpReply reply;
  if (!request) {
    reply = short_reply("405 Method Not Allowed", "Only GET is answered here.");
  } else if (hosts.size() > 1 || has_body) {
    reply = short_reply("400 Bad Request", "A request has one header Host and no body here.");
  } else if (only_loopback_ && (hosts.empty() || !names_loopback(hosts.front()))) {
    reply = short_reply("421 Misdirected Request", "This address answers to localhost, 127.0.0.1 and [::1] only.");
  } else {
    reply = handler_(*request);
  }
  if (!browser.send_text(header_of(reply)).ok() || !reply.body) return;
  browser.send_text(*reply.body).IgnoreError();
}

}  // namespace segserve::bench
