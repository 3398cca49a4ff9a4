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

/// What damaged bytes may ask for: far less than would hurt, far more than the samples need.
inline constexpr DecodeLimits kDamageLimits{.max_points = 100'000, .max_bytes = 2'000'000};

/// A decoder of damaged bytes says INVALID_ARGUMENT or gives a cloud within the limits whose planes fit each other.
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

/// No truncated payload is taken for a whole one. Each is an allocation of its own, so that ASan sees a read beyond it.
template <typename Decode>
void expect_truncations_refused(const std::string& bytes, Decode decode) {
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const absl::StatusOr<Cloud> cloud = decode(std::string(bytes.data(), size));
    ASSERT_EQ(cloud.status().code(), absl::StatusCode::kInvalidArgument) << "at " << size << " bytes";
  }
  EXPECT_TRUE(decode(bytes).ok());
}

/// Every byte, changed in several ways, one at a time.
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
