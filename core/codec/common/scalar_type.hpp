// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "segserve/codec/attribute.hpp"

namespace segserve::codec {

// Several decoders take little-endian numbers from memory as they are.
static_assert(std::endian::native == std::endian::little);

/// Calls `visitor` with a value of the C++ type, which is 0, and returns its result.
template <typename Visitor>
decltype(auto) visit_type(ScalarType type, Visitor&& visitor) {
  switch (type) {
    case ScalarType::kInt8:
      return visitor(std::int8_t{});
    case ScalarType::kInt16:
      return visitor(std::int16_t{});
    case ScalarType::kInt32:
      return visitor(std::int32_t{});
    case ScalarType::kInt64:
      return visitor(std::int64_t{});
    case ScalarType::kUint8:
      return visitor(std::uint8_t{});
    case ScalarType::kUint16:
      return visitor(std::uint16_t{});
    case ScalarType::kUint32:
      return visitor(std::uint32_t{});
    case ScalarType::kUint64:
      return visitor(std::uint64_t{});
    case ScalarType::kFloat32:
      return visitor(float{});
    case ScalarType::kFloat64:
      break;
  }
  return visitor(double{});
}

constexpr bool is_float(ScalarType type) { return type == ScalarType::kFloat32 || type == ScalarType::kFloat64; }

/// Reads a T from bytes of any alignment and either byte order.
template <typename T>
T load(const std::byte* bytes, std::endian order = std::endian::little) {
  static_assert(std::is_arithmetic_v<T>);
  std::array<std::byte, sizeof(T)> copy;
  std::memcpy(copy.data(), bytes, sizeof(T));
  if (order != std::endian::native) std::reverse(copy.begin(), copy.end());
  return std::bit_cast<T>(copy);
}

}  // namespace segserve::codec
