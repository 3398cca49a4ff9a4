#include "segserve/wire/labels.hpp"

#include "gmock/gmock.h"
#include "segserve/wire/status.hpp"

namespace segserve::wire {
namespace {

using testing::HasSubstr;

TEST(WireLabels, RoundTripInTheSmallestWidth) {
  const std::vector<std::pair<std::vector<std::uint32_t>, std::uint32_t>> cases = {
      {{}, 1}, {{0, 1, 255}, 1}, {{0, 256, 65535}, 2}, {{65536, 0xffffffff}, 4}};
  for (const auto& [labels, width] : cases) {
    for (const auto compression : {v1alpha1::COMPRESSION_NONE, v1alpha1::COMPRESSION_ZSTD}) {
      const auto message = to_message(labels, compression);
      ASSERT_TRUE(message.ok());
      EXPECT_EQ(message->bytes_per_label(), width);
      EXPECT_EQ(from_message(*message, labels.size(), 0xffffffff, "labels").value(), labels);
    }
  }
}

TEST(WireLabels, RefusesWhatDoesNotFit) {
  const v1alpha1::LabelArray good = to_message(std::vector<std::uint32_t>{1, 2, 3}, v1alpha1::COMPRESSION_NONE).value();
  const auto error_of = [](const v1alpha1::LabelArray& message, std::uint64_t points, std::uint32_t maximum) {
    const absl::Status status = from_message(message, points, maximum, "labels").status();
    EXPECT_EQ(details_of(status).reason, v1alpha1::ERROR_REASON_MALFORMED_PAYLOAD);
    return std::string(status.message());
  };
  EXPECT_THAT(error_of(good, 4, 3), HasSubstr("3 entries for 4 points"));
  EXPECT_THAT(error_of(good, 3, 2), HasSubstr("holds 3"));

  v1alpha1::LabelArray wide = good;
  wide.set_bytes_per_label(3);
  EXPECT_THAT(error_of(wide, 3, 3), HasSubstr("3 bytes per label"));
  wide.set_bytes_per_label(2);
  EXPECT_THAT(error_of(wide, 3, 3), HasSubstr("labels"));
}

}  // namespace
}  // namespace segserve::wire
