// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace segserve::server {

/// The answer to a request, or why there is none.
struct HttpAnswer {
  long status = 0;   ///< 0: there was no answer
  std::string body;  ///< its beginning, at most HttpPost::kMostAnswerBytes
  std::optional<std::chrono::seconds> retry_after;
  std::string error;  ///< why there was no answer
};

/// Posts bodies to one URL of http or https, one after the other, on a connection that it keeps. It follows no
/// redirects. One thread at a time may use an object, besides `wake`.
class HttpPost {
 public:
  using Time = std::chrono::steady_clock::time_point;
  static constexpr std::size_t kMostAnswerBytes = 4096;

  /// `ca_file` holds the certificates that are trusted, PEM; empty: those of the system.
  HttpPost(const std::string& url, const std::vector<std::pair<std::string, std::string>>& headers,
           const std::string& ca_file);
  ~HttpPost();
  HttpPost(const HttpPost&) = delete;
  HttpPost& operator=(const HttpPost&) = delete;

  /// Waits for the answer, at most until `deadline()`, which is asked again after every `wake`.
  HttpAnswer post(const std::string& body, const std::function<Time()>& deadline);
  /// Any thread may call it.
  void wake();

 private:
  struct Handles;
  std::unique_ptr<Handles> handles_;
};

}  // namespace segserve::server
