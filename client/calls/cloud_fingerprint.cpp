// SPDX-License-Identifier: Apache-2.0
#include "segserve/client/cloud_fingerprint.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <string_view>

#include "proto/wire/byte_run.hpp"

namespace segserve::client {
namespace {

static_assert(std::endian::native == std::endian::little, "the words below are hashed as they lie in memory");

constexpr std::size_t kBatch = 4096;  // points

/// The CRC-32 of `words_of(i)`, an array of 32-bit words, for every i below `count`.
template <std::size_t Words, typename WordsOf>
std::uint32_t crc32_of(std::size_t count, const WordsOf& words_of) {
  std::array<std::array<std::uint32_t, Words>, kBatch> batch;
  std::uint32_t crc = 0;
  for (std::size_t begin = 0; begin < count; begin += kBatch) {
    const std::size_t points = std::min(kBatch, count - begin);
    for (std::size_t i = 0; i < points; ++i) batch[i] = words_of(begin + i);
    const auto* bytes = reinterpret_cast<const char*>(batch.data());  // NOLINT: bytes of plain words
    crc = wire::crc32(crc, std::string_view(bytes, points * sizeof(batch[0])));
  }
  return crc;
}

}  // namespace

CloudFingerprint fingerprint(const CloudView& cloud) {
  constexpr std::uint32_t kNan = 0x7fc00000U;
  constexpr std::uint32_t kRgb = 0x00ffffffU;
  CloudFingerprint print;
  print.coordinates = crc32_of<3>(cloud.size(), [&](std::size_t i) -> std::array<std::uint32_t, 3> {
    const float x = cloud.x[i], y = cloud.y[i], z = cloud.z[i];
    if (!is_finite(x, y, z)) return {kNan, kNan, kNan};
    return {std::bit_cast<std::uint32_t>(x), std::bit_cast<std::uint32_t>(y), std::bit_cast<std::uint32_t>(z)};
  });
  if (cloud.has_color()) {
    print.colors = crc32_of<1>(cloud.size(), [&](std::size_t i) { return std::array{cloud.rgb[i] & kRgb}; });
  }
  return print;
}

}  // namespace segserve::client
