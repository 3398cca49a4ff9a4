// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace segserve::recording {

/// Reads little-endian numbers and runs of bytes from untrusted memory. Whatever lies beyond the end reads as zero or
/// empty, and `ok` is false from then on, so that a record is read first and checked once.
class ByteCursor {
 public:
  explicit ByteCursor(std::string_view bytes) : rest_(bytes) {}

  template <std::integral T>
  T number() {
    T value{};
    const std::string_view bytes = take(sizeof(T));
    if (bytes.size() == sizeof(T)) std::memcpy(&value, bytes.data(), sizeof(T));
    return value;
  }
  /// The next `count` bytes; none of them if there are fewer.
  std::string_view take(std::uint64_t count) {
    if (count > rest_.size()) {
      ok_ = false;
      rest_ = {};
    }
    const std::string_view taken = rest_.substr(0, static_cast<std::size_t>(ok_ ? count : 0));
    rest_.remove_prefix(taken.size());
    return taken;
  }
  /// Bytes behind their number, which is a T.
  template <std::integral T = std::uint32_t>
  std::string_view counted() {
    return take(number<T>());
  }

  bool ok() const { return ok_; }
  std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
  bool ok_ = true;
};

}  // namespace segserve::recording
