// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace segserve::codec {

/// The number types of the values that files have for each point.
enum class ScalarType : std::uint8_t {
  kInt8,
  kInt16,
  kInt32,
  kInt64,
  kUint8,
  kUint16,
  kUint32,
  kUint64,
  kFloat32,
  kFloat64,
};

/// Bytes of a number.
constexpr std::size_t size_of(ScalarType type) {
  constexpr std::array<std::size_t, 10> kSizes{1, 2, 4, 8, 1, 2, 4, 8, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

/// "int8", "uint32", "float64" and so on.
constexpr std::string_view name(ScalarType type) {
  constexpr std::array<std::string_view, 10> kNames{"int8",   "int16",  "int32",  "int64",   "uint8",
                                                    "uint16", "uint32", "uint64", "float32", "float64"};
  return kNames[static_cast<std::size_t>(type)];
}

/// Values that a file has for each of its N points beside position, color and label, such as intensity, time or
/// normals. They mean nothing to the segmentation, and go out again with the labels.
struct Attribute {
  std::string name;
  ScalarType type = ScalarType::kFloat32;
  std::size_t count = 1;          ///< numbers for each point
  std::vector<std::byte> values;  ///< N * count numbers, point by point, little endian

  std::size_t bytes_per_point() const { return size_of(type) * count; }
};

}  // namespace segserve::codec
