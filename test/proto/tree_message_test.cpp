// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/tree_message.hpp"

#include <cstdint>
#include <limits>
#include <string>

#include "gmock/gmock.h"
#include "proto/wire/integers_message.hpp"
#include "proto/wire/status_message.hpp"
#include "test/proto/example_messages.hpp"

namespace segserve::wire {
namespace {

using testing::HasSubstr;

constexpr std::uint32_t kLeaves = 3, kPoints = 5;  // These are the numbers of small_tree.
constexpr std::uint64_t kAbsurd = std::uint64_t{1} << 62U;

v1::MergeTree small_message() { return to_message(small_tree(), v1::COMPRESSION_NONE).value(); }

/// The message of the error for the small tree after a change.
template <typename Change>
std::string refusal(Change&& change) {
  v1::MergeTree message = small_message();
  change(message);
  const absl::Status status = from_message(message, kLeaves, kPoints).status();
  EXPECT_EQ(details_of(status).reason, ErrorReason::kMalformedPayload) << status;
  return std::string(status.message());
}

v1::IntegerArray array(const std::vector<std::uint32_t>& values) {
  return to_message(values, v1::COMPRESSION_NONE).value();
}

std::string bytes_of(const std::vector<double>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double)};
}

TEST(WireTree, RoundTrips) {
  for (const auto compression : {v1::COMPRESSION_NONE, v1::COMPRESSION_ZSTD}) {
    EXPECT_EQ(from_message(to_message(small_tree(), compression).value(), kLeaves, kPoints).value(), small_tree());
    EXPECT_EQ(from_message(to_message(MergeTree{}, compression).value(), 0, 0).value(), MergeTree{});
    for (const std::uint32_t leaves : {1U, 2U, 200U, 300U, 70'000U}) {
      EXPECT_EQ(from_message(to_message(chain_tree(leaves), compression).value(), leaves, leaves).value(),
                chain_tree(leaves));
    }
  }
}

TEST(WireTree, IsTheDocumentedBytes) {
  const v1::MergeTree message = small_message();
  EXPECT_EQ(message.leaf_points().count(), 3U);
  EXPECT_EQ(message.leaf_points().bytes_per_value(), 1U);
  EXPECT_EQ(message.leaf_points().data().data(), std::string("\2\2\1"));
  EXPECT_EQ(message.left().data().data(), std::string("\0\2", 2));
  EXPECT_EQ(message.right().data().data(), std::string("\1\3"));
  EXPECT_EQ(message.weight().data(), std::string("\0\0\0\0\0\0\xd0\x3f\0\0\0\0\0\0\xf0\x3f", 16));
  EXPECT_EQ(message.merged_rows(), 1U);
}

TEST(WireTree, CompressesTheColumnsThatGetSmaller) {
  const v1::MergeTree small = to_message(small_tree(), v1::COMPRESSION_ZSTD).value();
  EXPECT_EQ(small.weight().compression(), v1::COMPRESSION_NONE);
  const v1::MergeTree large = to_message(chain_tree(70'000), v1::COMPRESSION_ZSTD).value();
  EXPECT_EQ(large.leaf_points().data().compression(), v1::COMPRESSION_ZSTD);
  EXPECT_EQ(large.weight().compression(), v1::COMPRESSION_ZSTD);
  EXPECT_LT(large.ByteSizeLong(), to_message(chain_tree(70'000), v1::COMPRESSION_NONE)->ByteSizeLong() / 3);
}

TEST(WireTree, RefusesColumnsOfAnotherLength) {
  EXPECT_THAT(refusal([](auto& m) {
                *m.mutable_leaf_points() = array({2, 3});
              }),
              HasSubstr("tree.leaf_points: has 2 values, but must have 3"));
  EXPECT_THAT(refusal([](auto& m) { *m.mutable_left() = array({0}); }), HasSubstr("tree.left: has 1 values"));
  EXPECT_THAT(refusal([](auto& m) { *m.mutable_right() = array({1, 3, 4}); }), HasSubstr("tree.right: has 3 values"));
  EXPECT_THAT(refusal([](auto& m) { m.clear_weight(); }), HasSubstr("tree.weight: has 0 bytes, but must have 16"));
  EXPECT_THAT(refusal([](auto& m) { m.mutable_left()->mutable_data()->mutable_data()->push_back('x'); }),
              HasSubstr("tree.left"));
  EXPECT_THAT(refusal([](auto& m) { m.Clear(); }), HasSubstr("tree.leaf_points: has 0 values"));
  const v1::MergeTree message = small_message();
  EXPECT_THAT(std::string(from_message(message, kLeaves + 1, kPoints).status().message()), HasSubstr("must have 4"));
}

TEST(WireTree, RefusesLengthsThatTheBytesDoNotHave) {
  EXPECT_THAT(refusal([](auto& m) { m.mutable_leaf_points()->set_count(kAbsurd); }), HasSubstr("4611686018427387904"));
  EXPECT_THAT(refusal([](auto& m) { m.mutable_left()->mutable_data()->set_decoded_bytes(kAbsurd); }),
              HasSubstr("tree.left: claims 4611686018427387904 bytes, but must have 2"));
  EXPECT_THAT(refusal([](auto& m) { m.mutable_weight()->set_encoded_bytes(kAbsurd); }),
              HasSubstr("tree.weight: claims 4611686018427387904 encoded bytes"));
  EXPECT_THAT(refusal([](auto& m) { m.mutable_right()->set_bytes_per_value(3); }),
              HasSubstr("tree.right: has 3 bytes per value"));
  // If the summary agrees with an absurd number of supervoxels, the compressed bytes are too few for them.
  v1::MergeTree message = to_message(chain_tree(70'000), v1::COMPRESSION_ZSTD).value();
  constexpr std::uint32_t kMany = std::numeric_limits<std::uint32_t>::max();
  message.mutable_leaf_points()->set_count(kMany);
  message.mutable_leaf_points()->mutable_data()->set_decoded_bytes(kMany);
  EXPECT_THAT(std::string(from_message(message, kMany, kMany).status().message()), HasSubstr("tree.leaf_points"));
}

TEST(WireTree, RefusesColumnsThatAreNotATree) {
  EXPECT_THAT(refusal([](auto& m) { *m.mutable_left() = array({1, 2}); }), HasSubstr("row 0: left 1 and right 1"));
  EXPECT_THAT(refusal([](auto& m) {
                *m.mutable_right() = array({3, 4});
              }),
              HasSubstr("row 0"))
      << "node 3 is its own child";
  EXPECT_THAT(refusal([](auto& m) { m.set_merged_rows(3); }), HasSubstr("3 of 2 rows"));
  EXPECT_THAT(refusal([](auto& m) {
                m.mutable_weight()->set_data(bytes_of({std::numeric_limits<double>::quiet_NaN(), 1}));
              }),
              HasSubstr("row 0: weight nan"));
}

TEST(WireTree, MustHaveThePointsOfTheSummary) {
  EXPECT_THAT(refusal([](auto& m) {
                *m.mutable_leaf_points() = array({2, 2, 2});
              }),
              HasSubstr("tree.leaf_points: the sum is 6 points, but must be 5"));
}

}  // namespace
}  // namespace segserve::wire
