// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace segserve::server {

/// Names and values, in their order.
using HttpHeaders = std::vector<std::pair<std::string, std::string>>;

/// A request of HTTP/1.1 before its body.
struct HttpHead {
  std::string method;                            ///< e.g. "POST"
  std::string path;                              ///< as it was sent, without the query
  std::string query;                             ///< as it was sent, without the question mark
  HttpHeaders headers = {};                      ///< names in small letters
  std::optional<std::uint64_t> body_bytes = {};  ///< unset if the body comes in chunks
  std::string peer = {};                         ///< as gRPC names it, e.g. "ipv4:192.0.2.7:40312"
  std::string certificate_name = {};             ///< of the client's certificate, which TLS has verified; or empty

  /// The value of the first header with this name in small letters; empty if there is none.
  std::string_view header(std::string_view name) const {
    for (const auto& [key, value] : headers) {
      if (key == name) return value;
    }
    return {};
  }
};

/// The answer to a request.
struct HttpAnswer {
  unsigned status = 200;
  HttpHeaders headers = {};  ///< without those of the transport: Content-Length, Connection and Date
  std::string body = {};
  bool closes = false;               ///< whether the connection ends after it
  std::shared_ptr<void> owner = {};  ///< is kept until the client has read the answer
};

}  // namespace segserve::server
