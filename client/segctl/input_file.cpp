// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/input_file.hpp"

#include <cstdint>

#include "client/segctl/interrupt.hpp"
#include "core/base/input_bytes.hpp"
#include "core/base/status_text.hpp"
#include "fmt/format.h"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/stop_token.hpp"

namespace segserve::segctl {

std::string input_name(const std::string& path) { return path == "-" ? "standard input" : path; }

absl::StatusOr<std::string> read_input(const std::string& path) {
  constexpr std::uint64_t kMaxBytes = codec::DecodeLimits{}.max_bytes;
  auto bytes = read_input_bytes(path, kMaxBytes, StopToken(&Interrupt::signal_flag()));
  if (!bytes.ok()) {
    return absl::Status(bytes.status().code(),
                        fmt::format("cannot read {}: {}", input_name(path), message_of(bytes.status())));
  }
  if (bytes->size() <= kMaxBytes) return bytes;
  return absl::InvalidArgumentError(
      fmt::format("{} is larger than the {} bytes that are allowed", input_name(path), kMaxBytes));
}

}  // namespace segserve::segctl
