// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace segserve::bench {

/// One end of a TCP connection that carries lines of text. Not thread-safe.
class LineSocket {
 public:
  /// The longest line that is taken unless otherwise said, bytes.
  static constexpr std::size_t kMostBytes = std::size_t{64} << 20U;

  /// UNAVAILABLE with the reason if nobody takes the connection in time.
  static absl::StatusOr<LineSocket> connect(const std::string& host, const std::string& port,
                                            std::chrono::milliseconds timeout);
  /// Owns the descriptor, which must not block.
  explicit LineSocket(int descriptor) : descriptor_(descriptor) {}
  LineSocket(LineSocket&& other) noexcept;
  LineSocket& operator=(LineSocket&& other) noexcept;
  ~LineSocket();

  /// Sends the line and a line feed. UNAVAILABLE if the connection is cut, or the other end takes nothing for 10 s.
  absl::Status send(std::string_view line);
  /// Sends the text as it is, with the errors of `send`.
  absl::Status send_text(std::string_view text);
  /// The next line without its line feed; nothing if none has come within the time. UNAVAILABLE if the connection is
  /// over, or the line is longer than that.
  absl::StatusOr<std::optional<std::string>> receive(std::chrono::milliseconds time,
                                                     std::size_t most_bytes = kMostBytes);

 private:
  int descriptor_;
  std::string received_;
};

/// Takes connections. Not thread-safe.
class LineListener {
 public:
  /// Listens; port 0 is any free one. UNAVAILABLE with the reason if that fails.
  static absl::StatusOr<LineListener> listen(const std::string& host, const std::string& port);
  LineListener(LineListener&& other) noexcept;
  LineListener& operator=(LineListener&&) = delete;
  ~LineListener();

  int port() const;
  /// The next connection; nothing if none has come within the time.
  std::optional<LineSocket> accept(std::chrono::milliseconds time);

 private:
  explicit LineListener(int descriptor) : descriptor_(descriptor) {}

  int descriptor_;
};

}  // namespace segserve::bench
