// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/strings/cord.h"

namespace segserve {

/// The message of a status as a std::string, which fmt accepts.
inline std::string message_of(const absl::Status& status) { return std::string(status.message()); }

/// Returns the status with "<prefix>: " before its message.
inline absl::Status with_prefix(std::string_view prefix, const absl::Status& status) {
  absl::Status result(status.code(), std::string(prefix) + ": " + message_of(status));
  status.ForEachPayload([&](auto key, const absl::Cord& payload) { result.SetPayload(key, payload); });
  return result;
}

}  // namespace segserve
