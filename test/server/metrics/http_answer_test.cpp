// SPDX-License-Identifier: Apache-2.0
#include "server/metrics/http_answer.hpp"

#include <string>

#include "gmock/gmock.h"

namespace segserve::server {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

/// The first line of the answer; empty if there is none yet.
std::string status_of(std::string_view request) {
  const auto answer = http_answer(request, [] { return "page\n"; });
  return answer ? answer->substr(0, answer->find("\r\n")) : "";
}

TEST(HttpAnswer, IsThePageForThoseWhoAskForIt) {
  const auto answer = http_answer("GET /metrics?a=b HTTP/1.1\r\nHost: x\r\n\r\n", [] { return "page\n"; });
  ASSERT_TRUE(answer);
  EXPECT_THAT(*answer, StartsWith("HTTP/1.1 200 OK\r\nContent-Type: text/plain; version=0.0.4; charset=utf-8\r\n"));
  EXPECT_THAT(*answer, HasSubstr("\r\nContent-Length: 5\r\n"));
  EXPECT_THAT(*answer, EndsWith("\r\nConnection: close\r\n\r\npage\n"));
}

TEST(HttpAnswer, HasNoBodyForHead) {
  const auto answer = http_answer("HEAD /metrics HTTP/1.0\r\n\r\n", [] { return "page\n"; });
  ASSERT_TRUE(answer);
  EXPECT_THAT(*answer, HasSubstr("\r\nContent-Length: 5\r\n"));
  EXPECT_THAT(*answer, EndsWith("\r\n\r\n"));
}

TEST(HttpAnswer, WaitsForTheWholeRequestButNotForEver) {
  const std::string request = "GET /metrics HTTP/1.1\r\nHost: x\r\n\r\n";
  for (std::size_t bytes = 0; bytes < request.size(); ++bytes) EXPECT_EQ(status_of(request.substr(0, bytes)), "");
  EXPECT_EQ(status_of(std::string(kMostRequestBytes - 1, 'a')), "");
  EXPECT_EQ(status_of(std::string(kMostRequestBytes, 'a')), "HTTP/1.1 431 Request Header Fields Too Large");
}

TEST(HttpAnswer, IsAnErrorForAnythingElse) {
  EXPECT_EQ(status_of("GET / HTTP/1.1\r\n\r\n"), "HTTP/1.1 404 Not Found");
  EXPECT_EQ(status_of("GET /metrics/ HTTP/1.1\r\n\r\n"), "HTTP/1.1 404 Not Found");
  EXPECT_EQ(status_of("GET /metricsx HTTP/1.1\r\n\r\n"), "HTTP/1.1 404 Not Found");
  EXPECT_EQ(status_of("POST /metrics HTTP/1.1\r\n\r\n"), "HTTP/1.1 405 Method Not Allowed");
  EXPECT_EQ(status_of("GET /metrics\r\n\r\n"), "HTTP/1.1 400 Bad Request");
  EXPECT_EQ(status_of("GET /metrics HTTP/2\r\n\r\n"), "HTTP/1.1 400 Bad Request");
  EXPECT_EQ(status_of("\r\n\r\n"), "HTTP/1.1 400 Bad Request");
  EXPECT_EQ(status_of(std::string("\0\0\r\n\r\n", 6)), "HTTP/1.1 400 Bad Request");
}

TEST(HttpAnswer, RefusesWhenThereIsNoPageNow) {
  const auto answer = http_answer("GET /metrics HTTP/1.1\r\n\r\n", [] { return std::nullopt; });
  ASSERT_TRUE(answer);
  EXPECT_THAT(*answer, StartsWith("HTTP/1.1 429 Too Many Requests\r\n"));
}

}  // namespace
}  // namespace segserve::server
