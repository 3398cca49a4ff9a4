// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "spdlog/formatter.h"
#include "spdlog/pattern_formatter.h"

namespace segserve::server {

enum class LogFormat : std::uint8_t {
  kText,  ///< "2026-11-29T10:52:46.123+00:00 info message name=value .."
  kJson,  ///< {"time": "2026-11-29T10:52:46.123+00:00", "level": "info", "message": "..", "name": value, ..}
};

/// Makes one line of each message, whatever bytes are in it. As text, all that is not printable ASCII is escaped, and
/// JSON is always valid: bytes that are no UTF-8 become U+FFFD. A message is cut after kMostMessageBytes.
class LogFormatter final : public spdlog::formatter {
 public:
  static constexpr std::size_t kMostMessageBytes = 4096;

  explicit LogFormatter(LogFormat format);

  void format(const spdlog::details::log_msg& message, spdlog::memory_buf_t& line) override;
  std::unique_ptr<spdlog::formatter> clone() const override;

 private:
  const LogFormat format_;
  spdlog::pattern_formatter time_;  // RFC 3339, local time with its offset
};

}  // namespace segserve::server
