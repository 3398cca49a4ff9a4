// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"
#include "segserve/codec/decode_limits.hpp"

namespace segserve::codec {

/// Limits for damaged bytes. They are far above what the samples need, and far below what would do harm.
inline constexpr DecodeLimits kDamageLimits{.max_points = 100'000, .max_bytes = 2'000'000};

/// Expects INVALID_ARGUMENT, or a cloud within the limits whose planes fit each other.
inline void expect_sound(const absl::StatusOr<Cloud>& cloud) {
  if (!cloud.ok()) {
    ASSERT_EQ(cloud.status().code(), absl::StatusCode::kInvalidArgument) << cloud.status();
    ASSERT_FALSE(cloud.status().message().empty());
    return;
  }
  ASSERT_EQ(std::uint64_t{cloud->width} * cloud->height, cloud->size());
  ASSERT_LE(cloud->size(), kDamageLimits.max_points);
  ASSERT_EQ(cloud->y.size(), cloud->size());
  ASSERT_EQ(cloud->z.size(), cloud->size());
  ASSERT_TRUE(cloud->rgb.empty() || cloud->rgb.size() == cloud->size());
}

/// Expects that each truncation of `bytes` is refused. Each is an allocation of its own, so that ASan sees a read
/// beyond it.
template <typename Decode>
void expect_truncations_refused(const std::string& bytes, Decode decode) {
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const absl::StatusOr<Cloud> cloud = decode(std::string(bytes.data(), size));
    ASSERT_EQ(cloud.status().code(), absl::StatusCode::kInvalidArgument) << "at " << size << " bytes";
  }
  EXPECT_TRUE(decode(bytes).ok());
}

/// Changes every byte in several ways, one at a time, and expects a sound result of each.
template <typename Decode>
void expect_flips_survived(const std::string& bytes, Decode decode) {
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    for (const unsigned change : {0x01U, 0x10U, 0x80U, 0xffU}) {
      std::string damaged = bytes;
      damaged[at] = static_cast<char>(static_cast<unsigned char>(damaged[at]) ^ change);
      SCOPED_TRACE(testing::Message() << "byte " << at << " ^ " << change);
      ASSERT_NO_FATAL_FAILURE(expect_sound(decode(damaged)));
    }
  }
}

}  // namespace segserve::codec
