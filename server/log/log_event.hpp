// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "spdlog/common.h"

namespace segserve::server {

/// A value that belongs to a line of the log, under a name of its own. The name says the unit, e.g. "queue_ms". An
/// empty text is left out of the line. Clients may have chosen a text: it is escaped, and cut after kMostFieldBytes.
struct LogField {
  using Value = std::variant<std::string_view, std::int64_t, std::uint64_t, double>;

  LogField(std::string_view field_name, std::string_view text) : name(field_name), value(text) {}
  /// The text must outlive the field, which a temporary one does not.
  template <std::same_as<std::string> Temporary>
  LogField(std::string_view field_name, Temporary&& text) = delete;
  LogField(std::string_view field_name, std::floating_point auto number)
      : name(field_name), value(static_cast<double>(number)) {}
  LogField(std::string_view field_name, std::signed_integral auto number)
      : name(field_name), value(std::int64_t{number}) {}
  LogField(std::string_view field_name, std::unsigned_integral auto number)
      : name(field_name), value(std::uint64_t{number}) {}

  std::string_view name;
  Value value;
};

constexpr std::size_t kMostFieldBytes = 256;

/// Writes a line with fields to the log of spdlog, if it has this level: "message name=value .." as text, members of
/// one object as JSON. Any thread may call it. It waits for nothing and does not throw.
void log_event(spdlog::level::level_enum level, std::string_view message, std::span<const LogField> fields) noexcept;

}  // namespace segserve::server
