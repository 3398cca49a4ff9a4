// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <type_traits>

#include "client/recording/bytes/byte_cursor.hpp"

namespace segserve::recording {

/// How ROS writes the members of a message.
enum class RosWire : std::uint8_t {
  kCdr,   ///< ROS 2: CDR of DDS (OMG formal/2023-07-01 of DDS-XTypes, 7.4): aligned, of either byte order
  kRos1,  ///< ROS 1: packed, little-endian (http://wiki.ros.org/msg)
};

/// Reads the members of a ROS message from untrusted bytes, in their order. Like ByteCursor it reads zeros beyond the
/// end, and `ok` is false from then on.
class RosReader {
 public:
  /// Messages in CDR begin with 4 bytes that tell the byte order. `ok` is false for other representations than plain
  /// CDR, such as parameter lists.
  RosReader(std::string_view bytes, RosWire wire) : wire_(wire), cursor_(bytes) {
    if (wire == RosWire::kCdr) read_encapsulation();
    size_ = cursor_.rest().size();
  }

  template <typename T>
  requires std::is_arithmetic_v<T> T number() {
    align(sizeof(T));
    std::array<char, sizeof(T)> copy{};
    const std::string_view bytes = cursor_.take(sizeof(T));
    if (bytes.size() == sizeof(T)) std::memcpy(copy.data(), bytes.data(), sizeof(T));
    if (order_ != std::endian::native) std::reverse(copy.begin(), copy.end());
    return std::bit_cast<T>(copy);
  }
  /// The number of elements that follow; 0, and `ok` false, if so many of at least `bytes_each` cannot be there.
  std::uint32_t count(std::size_t bytes_each) {
    const auto claimed = number<std::uint32_t>();
    if (claimed <= cursor_.rest().size() / bytes_each) return claimed;
    wrong_ = true;
    return 0;
  }
  /// A sequence of bytes.
  std::string_view octets() { return cursor_.take(number<std::uint32_t>()); }
  std::string_view string() {
    std::string_view text = octets();
    if (wire_ == RosWire::kCdr && text.ends_with('\0')) text.remove_suffix(1);
    return text;
  }

  RosWire wire() const { return wire_; }
  bool ok() const { return cursor_.ok() && !wrong_; }

 private:
  void read_encapsulation() {
    cursor_.take(1);
    const auto kind = cursor_.number<std::uint8_t>();
    cursor_.take(2);
    wrong_ = kind != kCdrBig && kind != kCdrLittle && kind != kCdr2Big && kind != kCdr2Little;
    order_ = kind == kCdrLittle || kind == kCdr2Little ? std::endian::little : std::endian::big;
    max_alignment_ = kind == kCdr2Big || kind == kCdr2Little ? 4 : 8;
  }
  void align(std::size_t bytes) {
    if (wire_ == RosWire::kRos1) return;
    const std::size_t alignment = bytes < max_alignment_ ? bytes : max_alignment_;
    const std::size_t at = size_ - cursor_.rest().size();
    cursor_.take((alignment - at % alignment) % alignment);
  }

  static constexpr std::uint8_t kCdrBig = 0, kCdrLittle = 1, kCdr2Big = 6, kCdr2Little = 7;

  RosWire wire_;
  ByteCursor cursor_;
  std::endian order_ = std::endian::little;
  std::size_t max_alignment_ = 8;
  std::size_t size_ = 0;  ///< bytes behind the encapsulation
  bool wrong_ = false;
};

}  // namespace segserve::recording
