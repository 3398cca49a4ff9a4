// SPDX-License-Identifier: Apache-2.0
#include "core/codec/common/packed_integers.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/append_generated.hpp"
#include "core/codec/common/scalar_type.hpp"

namespace segserve::codec {
namespace {

/// The values as little-endian T, which holds all of them.
template <typename T>
std::string narrow(std::span<const std::uint32_t> values) {
  std::string bytes(values.size() * sizeof(T), '\0');
  char* out = bytes.data();
  for (const std::uint32_t element : values) {
    const T value = static_cast<T>(element);
    std::memcpy(out, &value, sizeof(T));
    out += sizeof(T);
  }
  return bytes;
}

/// The little-endian T of `bytes` as 32-bit integers.
template <typename T>
std::vector<std::uint32_t> widen(std::string_view bytes) {
  std::vector<std::uint32_t> values;
  const auto* in = reinterpret_cast<const std::byte*>(bytes.data());
  math::append_generated(values, 0, bytes.size() / sizeof(T),
                         [in](std::size_t i) { return std::uint32_t{load<T>(in + i * sizeof(T))}; });
  return values;
}

}  // namespace

EncodedIntegers encode_integers(std::span<const std::uint32_t> values) {
  const std::uint32_t largest = values.empty() ? 0 : *std::max_element(values.begin(), values.end());
  if (largest <= 0xFFU) return {narrow<std::uint8_t>(values), 1};
  if (largest <= 0xFFFFU) return {narrow<std::uint16_t>(values), 2};
  return {narrow<std::uint32_t>(values), 4};
}

absl::StatusOr<std::vector<std::uint32_t>> decode_integers(std::string_view bytes, std::uint32_t bytes_per_value) {
  if (bytes_per_value != 1 && bytes_per_value != 2 && bytes_per_value != 4) {
    return absl::InvalidArgumentError(
        fmt::format("{} bytes per value, but only 1, 2 and 4 are possible", bytes_per_value));
  }
  if (bytes.size() % bytes_per_value != 0) {
    return absl::InvalidArgumentError(
        fmt::format("{} bytes are not a whole number of values of {} bytes", bytes.size(), bytes_per_value));
  }
  if (bytes_per_value == 1) return widen<std::uint8_t>(bytes);
  if (bytes_per_value == 2) return widen<std::uint16_t>(bytes);
  return widen<std::uint32_t>(bytes);
}

}  // namespace segserve::codec
