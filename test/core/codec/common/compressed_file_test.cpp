// SPDX-License-Identifier: Apache-2.0
#include "core/codec/common/compressed_file.hpp"

#include <zlib.h>
#include <zstd.h>

#include <atomic>

#include "segserve/codec/cloud_file.hpp"
#include "segserve/codec/pcd.hpp"
#include "test/core/codec/support/damaged_bytes.hpp"
#include "test/core/codec/support/deflate_bytes.hpp"
#include "test/core/codec/support/sample_cloud.hpp"

namespace segserve::codec {
namespace {

using testing::HasSubstr;

std::string gzip(const std::string& bytes) { return deflate_bytes(bytes, 16 + MAX_WBITS); }

std::string zstd(const std::string& bytes) {
  std::string out(ZSTD_compressBound(bytes.size()), '\0');
  out.resize(ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 3));
  return out;
}

absl::StatusOr<Cloud> decode(const std::string& bytes) {
  auto cloud = decode_cloud(bytes_of(bytes), kDamageLimits);
  if (!cloud.ok()) return cloud.status();
  return cloud->cloud;
}

TEST(CompressedFile, FilesOfOneAndOfSeveralMembersAreRead) {
  const Sample sample = make_sample(1, 300, 200, true, true);
  const std::string pcd = encode_pcd(sample.cloud, sample.label, PcdEncoding::kBinary);
  for (const auto& pack : {gzip, zstd}) {
    for (const std::string& file : {pack(pcd), pack(pcd.substr(0, 1000)) + pack(pcd.substr(1000))}) {
      const auto cloud = decode_cloud(bytes_of(file), {});
      ASSERT_TRUE(cloud.ok()) << cloud.status();
      expect_same_points(cloud->cloud, sample.cloud);
      EXPECT_EQ(cloud->label, sample.label);
      EXPECT_FALSE(is_taken_as_pcd(bytes_of(file)));
    }
  }
}

TEST(CompressedFile, FramesOfZstdToSkipAreSkipped) {
  const std::string skipped = "\x50\x2a\x4d\x18" + std::string("\4\0\0\0", 4) + "what";
  const std::string last = "\x5f\x2a\x4d\x18" + std::string("\2\0\0\0", 4) + "so";
  for (const std::string& file :
       {skipped + zstd("1 2 3\n"), zstd("1 2 3\n") + last, skipped + zstd("1 2 ") + last + zstd("3\n")}) {
    const auto cloud = decode_cloud(bytes_of(file), {});
    ASSERT_TRUE(cloud.ok()) << cloud.status();
    EXPECT_EQ(cloud->cloud.size(), 1U);
    EXPECT_TRUE(cloud->warnings.empty());
  }
}

TEST(CompressedFile, WhatFollowsIsMentionedUnlessItIsZeros) {
  for (const auto& pack : {gzip, zstd}) {
    const auto padded = decode_cloud(bytes_of(pack("1 2 3\n") + std::string(9, '\0')), {});
    ASSERT_TRUE(padded.ok()) << padded.status();
    EXPECT_TRUE(padded->warnings.empty());
    const auto more = decode_cloud(bytes_of(pack("1 2 3\n") + "more"), {});
    ASSERT_TRUE(more.ok()) << more.status();
    ASSERT_EQ(more->warnings.size(), 1U);
    EXPECT_THAT(more->warnings[0].message, HasSubstr("4 bytes behind the "));
  }
}

TEST(CompressedFile, BombsAndNestingAreRefused) {
  const std::string zeros(8'000'000, '\0');
  for (const auto& pack : {gzip, zstd}) {
    expect_over_limit(decode_cloud(bytes_of(pack(zeros)), {.max_bytes = 1'000'000}).status(), "max_bytes",
                      "decompresses to more bytes than the limit of 1000000");
    expect_fault(decode_cloud(bytes_of(pack(pack("1 2 3\n"))), {}).status(), "within a compressed file");
  }
}

TEST(CompressedFile, WhatWasDecompressedCountsTowardsTheLimit) {
  std::string rows;
  for (int i = 0; i < 1000; ++i) rows += "0 0 1\n";  // 6000 bytes become 3 doubles each.
  const std::string file = zstd(rows);
  EXPECT_TRUE(decode_cloud(bytes_of(file), {.max_bytes = 30'000}).ok());
  const absl::Status status = decode_cloud(bytes_of(file), {.max_bytes = 29'999}).status();
  expect_over_limit(status, "max_bytes", "its 6000 decompressed bytes count, too, towards the limit of 29999");
  EXPECT_EQ(limit_excess(status)->actual, 30'000U);
}

TEST(CompressedFile, DamageIsRefused) {
  std::string rows;
  for (int i = 0; i < 40; ++i) rows += std::to_string(i) + " 2 3\n";
  for (const auto& pack : {gzip, zstd}) {
    const std::string file = pack(rows);
    expect_truncations_refused(file, decode);
    expect_flips_survived(file, decode);
  }
}

TEST(CompressedFile, AStopIsHeard) {
  const std::string zeros(8'000'000, '\0');
  for (const auto& pack : {gzip, zstd}) {
    const std::atomic<bool> cancelled = true;
    WorkMeter meter;
    const StopToken stop(&cancelled, std::nullopt, &meter);
    EXPECT_EQ(decode_cloud(bytes_of(pack(zeros)), {}, {}, stop).status().code(), absl::StatusCode::kCancelled);
    EXPECT_LE(meter.units(), StopToken::kMostWorkAfterStop);
  }
}

TEST(CompressedFile, ADeflateStreamMustFillItsClaim) {
  const std::string packed = gzip("hello hello hello");
  const auto stream = bytes_of(packed).subspan(10, packed.size() - 18);  // without the header and the trailer of gzip
  const StopToken stop;
  StopCheck check(stop);
  EXPECT_EQ(inflate_exactly(stream, 17, "a", check)->size(), 17U);
  expect_fault(inflate_exactly(stream, 16, "a", check).status(), "a: ");
  expect_fault(inflate_exactly(stream, 18, "a", check).status(), "a: it decompresses to 17 bytes, not the claimed 18");
  expect_fault(inflate_exactly(stream, 10'000'000, "a", check).status(), "cannot hold the claimed");
}

}  // namespace
}  // namespace segserve::codec
