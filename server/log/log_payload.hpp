// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/log/log_event.hpp"
#include "spdlog/details/log_msg.h"

// How a message and its fields travel through spdlog, which knows nothing of fields, from log_event to LogFormatter.
namespace segserve::server {

/// A field as the formatter sees it. A number is the digits of a JSON number.
struct PackedField {
  std::string_view name, value;
  bool is_number = false;
};

struct UnpackedPayload {
  std::string_view message;
  std::vector<PackedField> fields;
};

/// Marks a message that holds fields, so that no text can pretend to.
spdlog::source_loc fields_mark();

std::string pack_payload(std::string_view message, std::span<const LogField> fields);
/// The views are of the message's own bytes. A message without the mark has no fields.
UnpackedPayload unpack_payload(const spdlog::details::log_msg& message);

}  // namespace segserve::server
