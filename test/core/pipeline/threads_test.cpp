// SPDX-License-Identifier: Apache-2.0
#include <new>

#include "gmock/gmock.h"
#include "segserve/segment.hpp"
#include "test/core/support/clouds.hpp"

namespace segserve {
namespace {

/// A meter whose callback throws on each thread, once: at its first report since the last call of `arm`.
class ThrowingMeter {
 public:
  void arm() { ++armed_; }
  StopToken token() { return StopToken(nullptr, std::nullopt, &meter_); }

 private:
  void report() const {
    thread_local int thrown = 0;
    if (thrown == armed_) return;
    thrown = armed_;
    throw std::bad_alloc();
  }

  static int armed_;
  WorkMeter meter_{[this](std::uint64_t) { report(); }};
};

int ThrowingMeter::armed_ = 0;

class ThreadsTest : public testing::TestWithParam<std::uint32_t> {};
INSTANTIATE_TEST_SUITE_P(Threads, ThreadsTest, testing::Values(1U, 2U, 5U));

TEST_P(ThreadsTest, AnExceptionOfSegmentReachesTheCaller) {
  const Cloud cloud = test::random_cloud(100'000, 0.5F, 1, View::camera());
  const Options options{.threads = GetParam()};
  Segmenter segmenter;
  const Segmentation expected = *segmenter.segment(cloud, options);
  ThrowingMeter meter;
  meter.arm();
  EXPECT_THROW((void)segmenter.segment(cloud, options, meter.token()), std::bad_alloc);
  EXPECT_EQ(segmenter.segment(cloud, options)->labels, expected.labels) << "the segmenter is of use afterward";
}

TEST_P(ThreadsTest, AnExceptionOfDescribeReachesTheCaller) {
  const Cloud cloud = test::random_cloud(100'000, 0.5F, 1, View::camera());
  Segmentation segmentation = *segment(cloud, {});
  ThrowingMeter meter;
  meter.arm();
  EXPECT_THROW((void)describe(cloud, GetParam(), meter.token(), segmentation), std::bad_alloc);
  EXPECT_TRUE(segmentation.statistics.empty());
}

TEST(ThreadsTest, MayChangeFromFrameToFrame) {
  const Cloud cloud = test::random_cloud(20'000, 0.5F, 1, View::camera());
  Segmenter segmenter;
  const Segmentation one = *segmenter.segment(cloud, {.threads = 1});
  for (const std::uint32_t threads : {3U, 1U, 2U}) {
    EXPECT_EQ(segmenter.segment(cloud, {.threads = threads})->labels, one.labels) << threads;
  }
}

}  // namespace
}  // namespace segserve
