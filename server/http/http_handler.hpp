// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <variant>

#include "server/http/http_message.hpp"
#include "server/stream/session_protocol.hpp"

// The interface of the application behind a server of HTTP.
namespace segserve::server {

/// A request whose body is read. The server calls `reserve` before it reads on, and then either `finish` once or
/// destroys the object, one call after the other.
class HttpUpload {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Done = std::function<void(HttpAnswer)>;

  virtual ~HttpUpload() = default;

  /// The most bytes that the body may have.
  virtual std::uint64_t most_bytes() const = 0;
  /// The client says that the body has so many bytes. An answer refuses that. It takes no memory, because anybody can
  /// say anything.
  virtual std::optional<HttpAnswer> announce(std::uint64_t bytes) = 0;
  /// The body takes so many bytes of memory from now on. An answer refuses that.
  virtual std::optional<HttpAnswer> reserve(std::uint64_t bytes) = 0;
  /// The body did not come in time, or is broken; `why` says so. Returns the answer.
  virtual HttpAnswer stalled() = 0;
  virtual HttpAnswer broken(std::string_view why) = 0;
  /// The body is complete. Calls `done` exactly once, from any thread, maybe before it returns. Does not wait.
  virtual void finish(std::string body, Done done) = 0;
  /// The client has gone: nobody will read the answer, which must come all the same.
  virtual void cancel() = 0;
  /// Time has passed since `finish`.
  virtual void on_tick(Time now) = 0;
};

/// Decides what happens to requests. Thread-safe, and never waits.
class HttpHandler {
 public:
  virtual ~HttpHandler() = default;

  /// A request has come, but for its body. Either answers at once, or takes the body.
  virtual std::variant<HttpAnswer, std::shared_ptr<HttpUpload>> begin(const HttpHead& head) = 0;

  /// How fast uploads must be, and how long a client may take to read 256 KiB of an answer, at this moment.
  virtual UploadPace upload_pace() const = 0;
  virtual std::chrono::milliseconds answer_timeout() const = 0;
};

}  // namespace segserve::server
