// SPDX-License-Identifier: Apache-2.0
#include "server/log/log_payload.hpp"

#include <cmath>
#include <iterator>

#include "fmt/format.h"

namespace segserve::server {
namespace {

constexpr char kFieldBegin = '\x1e', kValueBegin = '\x1f';
constexpr char kText = 't', kNumber = 'n';
constexpr const char* kMark = "fields";

/// Appends a text in which nothing can be taken for a separator.
void append_text(std::string_view text, std::string& packed) {
  for (const char byte : text) packed += byte == kFieldBegin || byte == kValueBegin ? '?' : byte;
}

void append_field(const LogField& field, std::string& packed) {
  const auto* text = std::get_if<std::string_view>(&field.value);
  const auto* real = std::get_if<double>(&field.value);
  if (text != nullptr && text->empty()) return;
  if (real != nullptr && !std::isfinite(*real)) return;  // JSON has no such number
  packed += kFieldBegin;
  packed += field.name;
  packed += kValueBegin;
  packed += text != nullptr ? kText : kNumber;
  if (text != nullptr) {
    append_text(text->substr(0, kMostFieldBytes), packed);
    if (text->size() > kMostFieldBytes) packed += "...";
  } else if (real != nullptr) {
    fmt::format_to(std::back_inserter(packed), "{:.3f}", *real);
  } else if (const auto* natural = std::get_if<std::uint64_t>(&field.value)) {
    fmt::format_to(std::back_inserter(packed), "{}", *natural);
  } else {
    fmt::format_to(std::back_inserter(packed), "{}", std::get<std::int64_t>(field.value));
  }
}

PackedField unpack_field(std::string_view field) {
  const std::size_t end_of_name = field.find(kValueBegin);
  return {.name = field.substr(0, end_of_name),
          .value = field.substr(end_of_name + 2),
          .is_number = field[end_of_name + 1] == kNumber};
}

}  // namespace

spdlog::source_loc fields_mark() { return {kMark, 1, ""}; }

std::string pack_payload(std::string_view message, std::span<const LogField> fields) {
  std::string packed;
  append_text(message, packed);
  for (const LogField& field : fields) append_field(field, packed);
  return packed;
}

UnpackedPayload unpack_payload(const spdlog::details::log_msg& message) {
  std::string_view rest(message.payload.data(), message.payload.size());
  if (message.source.filename != kMark) return {.message = rest, .fields = {}};
  std::size_t end = rest.find(kFieldBegin);
  UnpackedPayload unpacked{.message = rest.substr(0, end), .fields = {}};
  while (end != std::string_view::npos) {
    rest.remove_prefix(end + 1);
    end = rest.find(kFieldBegin);
    unpacked.fields.push_back(unpack_field(rest.substr(0, end)));
  }
  return unpacked;
}

}  // namespace segserve::server
