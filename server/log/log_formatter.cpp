// SPDX-License-Identifier: Apache-2.0
#include "server/log/log_formatter.hpp"

#include <algorithm>
#include <string>
#include <string_view>

#include "fmt/format.h"
#include "nlohmann/json.hpp"
#include "server/log/log_payload.hpp"

namespace segserve::server {
namespace {

using Line = spdlog::memory_buf_t;

void append(std::string_view text, Line& line) { line.append(text.data(), text.data() + text.size()); }

std::string_view level_name(spdlog::level::level_enum level) {
  const auto name = spdlog::level::to_string_view(level);
  return {name.data(), name.size()};
}

bool is_printable(char byte) { return byte >= ' ' && byte <= '~'; }

/// Appends printable ASCII as it is, and every other byte as \xNN. Between quotes, these and backslashes are escaped.
void append_escaped(std::string_view text, bool quoted, Line& line) {
  for (const char byte : text) {
    if (!is_printable(byte)) {
      append(fmt::format("\\x{:02x}", static_cast<unsigned char>(byte)), line);
    } else {
      if (quoted && (byte == '"' || byte == '\\')) line.push_back('\\');
      line.push_back(byte);
    }
  }
}

void append_text_value(std::string_view value, Line& line) {
  const bool is_plain = std::ranges::all_of(value, [](char byte) {
    return is_printable(byte) && std::string_view(" \"\\='").find(byte) == std::string_view::npos;
  });
  if (is_plain) return append(value, line);
  line.push_back('"');
  append_escaped(value, true, line);
  line.push_back('"');
}

void append_json(std::string_view text, Line& line) {
  append(nlohmann::json(text).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace), line);
}

void append_text_line(const UnpackedPayload& payload, Line& line) {
  append_escaped(payload.message, false, line);
  for (const PackedField& field : payload.fields) {
    line.push_back(' ');
    append(field.name, line);
    line.push_back('=');
    append_text_value(field.value, line);
  }
}

void append_json_members(const UnpackedPayload& payload, Line& line) {
  append(R"(,"message":)", line);
  append_json(payload.message, line);
  for (const PackedField& field : payload.fields) {
    line.push_back(',');
    append_json(field.name, line);
    line.push_back(':');
    if (field.is_number) {
      append(field.value, line);
    } else {
      append_json(field.value, line);
    }
  }
}

}  // namespace

LogFormatter::LogFormatter(LogFormat format)
    : format_(format), time_("%Y-%m-%dT%H:%M:%S.%e%z", spdlog::pattern_time_type::local, "") {}

std::unique_ptr<spdlog::formatter> LogFormatter::clone() const { return std::make_unique<LogFormatter>(format_); }

void LogFormatter::format(const spdlog::details::log_msg& message, Line& line) {
  UnpackedPayload payload = unpack_payload(message);
  payload.message = payload.message.substr(0, kMostMessageBytes);
  if (format_ == LogFormat::kJson) {
    append(R"({"time":")", line);
    time_.format(message, line);
    append(fmt::format(R"(","level":"{}")", level_name(message.level)), line);
    append_json_members(payload, line);
    line.push_back('}');
  } else {
    time_.format(message, line);
    line.push_back(' ');
    message.color_range_start = line.size();
    append(level_name(message.level), line);
    message.color_range_end = line.size();
    line.push_back(' ');
    append_text_line(payload, line);
  }
  line.push_back('\n');
}

}  // namespace segserve::server
