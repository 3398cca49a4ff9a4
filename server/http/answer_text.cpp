// SPDX-License-Identifier: Apache-2.0
#include "server/http/answer_text.hpp"

#include <boost/beast/http/status.hpp>
#include <chrono>
#include <ctime>
#include <iterator>

#include "fmt/chrono.h"
#include "fmt/format.h"

namespace segserve::server {
namespace {

/// "Client Closed Request" is of no standard; Connect uses it for calls that were canceled.
std::string reason_of(unsigned status) {
  if (status == 499) return "Client Closed Request";
  return std::string(boost::beast::http::obsolete_reason(static_cast<boost::beast::http::status>(status)));
}

}  // namespace

std::string answer_header(const HttpAnswer& answer, bool closes) {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::string text = fmt::format("HTTP/1.1 {} {}\r\nDate: {:%a, %d %b %Y %H:%M:%S} GMT\r\n", answer.status,
                                 reason_of(answer.status), fmt::gmtime(now));
  for (const auto& [name, value] : answer.headers) {
    fmt::format_to(std::back_inserter(text), "{}: {}\r\n", name, value);
  }
  // An answer 204 has no body, and so no length of it.
  if (answer.status != 204) fmt::format_to(std::back_inserter(text), "Content-Length: {}\r\n", answer.body.size());
  text += closes ? "Connection: close\r\n\r\n" : "Connection: keep-alive\r\n\r\n";
  return text;
}

}  // namespace segserve::server
