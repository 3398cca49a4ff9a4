// SPDX-License-Identifier: Apache-2.0
#include "core/codec/common/zstd_block.hpp"

#include <zstd.h>

#include "test/core/codec/support/sample_cloud.hpp"

namespace segserve::codec {
namespace {

std::string noise(std::size_t size) {
  std::mt19937 random(7);
  std::string bytes(size, '\0');
  for (char& byte : bytes) byte = static_cast<char>(random() % 7);
  return bytes;
}

TEST(Zstd, RoundTripsAtAnyLevelAndSize) {
  for (const std::size_t size : {0UL, 1UL, 1000UL, 1UL << 20U}) {
    const std::string bytes = noise(size);
    for (const int level : {-5, 1, 3, 19}) {
      const auto small = zstd_compress(bytes, level);
      ASSERT_TRUE(small.ok()) << small.status();
      const auto back = zstd_decompress(*small, size);
      ASSERT_TRUE(back.ok()) << back.status();
      EXPECT_EQ(*back, bytes);
    }
  }
}

TEST(Zstd, AFrameThatDoesNotDeclareItsSizeIsRead) {
  const std::string bytes = noise(300'000);
  std::string frame(ZSTD_compressBound(bytes.size()), '\0');
  ZSTD_CCtx* context = ZSTD_createCCtx();
  ZSTD_CCtx_setParameter(context, ZSTD_c_contentSizeFlag, 0);
  frame.resize(ZSTD_compress2(context, frame.data(), frame.size(), bytes.data(), bytes.size()));
  ZSTD_freeCCtx(context);
  EXPECT_EQ(zstd_decompress(frame, bytes.size()).value_or(""), bytes);
  expect_fault(zstd_decompress(frame, bytes.size() + 1).status(),
               "the frame decodes to 300000 bytes, not the claimed 300001");
  expect_fault(zstd_decompress(frame, bytes.size() - 1).status(), "the claimed size is 299999 bytes");
  expect_fault(zstd_decompress(frame.substr(0, 20), std::size_t{1} << 31U).status(),
               "20 bytes cannot hold the claimed 2147483648 bytes");
}

TEST(Zstd, WrongClaimsAreNamed) {
  const std::string bytes = noise(1000);
  const std::string good = zstd_compress(bytes, 1).value();
  expect_fault(zstd_compress(bytes, 20).status(), "zstd level 20 is not in -100 to 19");
  expect_fault(zstd_decompress(good, 999).status(), "declares 1000 bytes, not the claimed 999");
  expect_over_limit(zstd_decompress(good, 1000, {.max_bytes = 999}).status(), "max_bytes",
                    "the claimed 1000 bytes exceed the limit of 999 bytes");
  expect_fault(zstd_decompress(good, std::numeric_limits<std::size_t>::max()).status(), "exceed the limit");
  expect_fault(zstd_decompress("no zstd at all", 10).status(), "do not begin with a zstd frame");
  expect_fault(zstd_decompress("", 0).status(), "do not begin with a zstd frame");
}

TEST(Zstd, TruncatedFramesAreRefused) {
  const std::string good = zstd_compress(noise(1000), 1).value();
  for (std::size_t size = 0; size < good.size(); ++size) {
    EXPECT_FALSE(zstd_decompress(good.substr(0, size), 1000).ok()) << size;
  }
}

}  // namespace
}  // namespace segserve::codec
