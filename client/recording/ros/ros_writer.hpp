// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "client/recording/bytes/append.hpp"
#include "client/recording/ros/ros_reader.hpp"

namespace segserve::recording {

/// Writes the members of a ROS message, little-endian, as RosReader reads them.
class RosWriter {
 public:
  explicit RosWriter(RosWire wire) : wire_(wire) {
    constexpr std::string_view kCdrLittleEndian("\0\1\0\0", 4);
    if (wire == RosWire::kCdr) out_ = kCdrLittleEndian;
    begin_ = out_.size();
  }

  template <std::integral T>
  void number(T value) {
    if (wire_ == RosWire::kCdr) {
      while ((out_.size() - begin_) % sizeof(T) != 0) out_ += '\0';
    }
    append_number(out_, value);
  }
  void octets(std::string_view bytes) {
    number(static_cast<std::uint32_t>(bytes.size()));
    out_ += bytes;
  }
  void string(std::string_view text) {
    const bool terminated = wire_ == RosWire::kCdr;
    number(static_cast<std::uint32_t>(text.size() + (terminated ? 1 : 0)));
    out_ += text;
    if (terminated) out_ += '\0';
  }

  std::string take() { return std::move(out_); }

 private:
  RosWire wire_;
  std::string out_;
  std::size_t begin_ = 0;
};

}  // namespace segserve::recording
