// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/integers_message.hpp"

#include "gmock/gmock.h"
#include "proto/wire/status_message.hpp"

namespace segserve::wire {
namespace {

using testing::HasSubstr;

TEST(WireIntegers, RoundTripInTheSmallestWidth) {
  const std::vector<std::pair<std::vector<std::uint32_t>, std::uint32_t>> cases = {
      {{}, 1}, {{0, 1, 255}, 1}, {{0, 256, 65535}, 2}, {{65536, 0xffffffff}, 4}};
  for (const auto& [values, width] : cases) {
    for (const auto compression : {v1::COMPRESSION_NONE, v1::COMPRESSION_ZSTD}) {
      const auto message = to_message(values, compression);
      ASSERT_TRUE(message.ok());
      EXPECT_EQ(message->bytes_per_value(), width);
      EXPECT_EQ(from_message(*message, values.size(), 0xffffffff, "ids").value(), values);
    }
  }
}

TEST(WireIntegers, RefusesAnotherCountRangeOrWidth) {
  const v1::IntegerArray good = to_message(std::vector<std::uint32_t>{1, 2, 3}, v1::COMPRESSION_NONE).value();
  const auto error_of = [](const v1::IntegerArray& message, std::uint64_t count, std::uint32_t maximum) {
    const absl::Status status = from_message(message, count, maximum, "ids").status();
    EXPECT_EQ(details_of(status).reason, ErrorReason::kMalformedPayload);
    return std::string(status.message());
  };
  EXPECT_THAT(error_of(good, 4, 3), HasSubstr("ids: has 3 values, but must have 4"));
  EXPECT_THAT(error_of(good, 3, 2), HasSubstr("ids: holds 3, but the largest allowed value is 2"));

  v1::IntegerArray wide = good;
  wide.set_bytes_per_value(3);
  EXPECT_THAT(error_of(wide, 3, 3), HasSubstr("ids: has 3 bytes per value, but must have 1, 2 or 4"));
  wide.set_bytes_per_value(2);
  EXPECT_THAT(error_of(wide, 3, 3), HasSubstr("ids: claims 3 bytes, but must have 6"));
}

/// The count comes from a result whose summary agrees with it, so that only the size of the bytes refutes it.
TEST(WireIntegers, RefusesACountWhoseBytesOverflow) {
  constexpr std::uint64_t kCount = (std::uint64_t{1} << 62U) + 1;  // Times 4 it is 4 in 64 bits.
  v1::IntegerArray message = to_message(std::vector<std::uint32_t>{0xffffffff}, v1::COMPRESSION_NONE).value();
  message.set_count(kCount);
  const absl::Status status = from_message(message, kCount, 0xffffffff, "ids").status();
  EXPECT_EQ(details_of(status).reason, ErrorReason::kMalformedPayload) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("ids: 4611686018427387905 values of 4 bytes"));
}

}  // namespace
}  // namespace segserve::wire
