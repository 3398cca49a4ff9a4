// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

namespace segserve::recording {

/// Appends a little-endian number.
template <std::integral T>
void append_number(std::string& out, T value) {
  char bytes[sizeof(T)];  // NOLINT(modernize-avoid-c-arrays)
  std::memcpy(bytes, &value, sizeof(T));
  out.append(bytes, sizeof(T));
}

/// Appends bytes behind their number, which is a T.
template <std::integral T = std::uint32_t>
void append_counted(std::string& out, std::string_view bytes) {
  append_number(out, static_cast<T>(bytes.size()));
  out.append(bytes);
}

}  // namespace segserve::recording
