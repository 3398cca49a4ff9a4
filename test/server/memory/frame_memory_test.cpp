// SPDX-License-Identifier: Apache-2.0
#include "server/memory/frame_memory.hpp"

#include <map>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "proto/wire/status_message.hpp"

namespace segserve::server {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::uint64_t kMegabyte = 1'000'000;
constexpr std::uint64_t kMostVoxels = 50'000;

FrameSize frame_of(std::size_t points, std::size_t voxels) {
  FrameSize size;
  size.points = points;
  size.voxels = voxels;
  size.workspace_bytes = workspace_bytes(points, voxels);
  size.resolution_for = [](std::size_t most) { return 1.0 / static_cast<double>(most); };
  return size;
}

TEST(FrameMemory, GrowsWithTheFrameAndEndsWithItsResult) {
  MemoryLedger ledger(100 * kMegabyte);
  {
    FrameMemory memory(ledger, {"here", "me"}, kMostVoxels);
    ASSERT_TRUE(memory.receive(kMegabyte).ok());
    EXPECT_EQ(ledger.leased(), kMegabyte);
    EXPECT_THAT(ledger.use().leased, ElementsAre(kMegabyte, 0, 0)) << "it waits";
    ASSERT_TRUE(memory.decode(10'000, 3 * kMegabyte).ok());
    EXPECT_EQ(ledger.leased(), 4 * kMegabyte + 16 * 10'000);
    ASSERT_TRUE(memory.voxelize(10'000).ok());
    ASSERT_TRUE(memory.segment(frame_of(10'000, 2'000)).ok());
    EXPECT_GT(ledger.leased(), workspace_bytes(10'000, 2'000));
    EXPECT_THAT(ledger.use().leased, ElementsAre(0, ledger.leased(), 0)) << "it is computed";
    memory.keep_result(123);
    EXPECT_THAT(ledger.use().leased, ElementsAre(0, 0, 123)) << "its result is not read yet";
    EXPECT_EQ(ledger.leased(), 123U);
  }
  EXPECT_THAT(ledger.use().leased, ElementsAre(0, 0, 0));
}

TEST(FrameMemory, AFrameOfTooManyVoxelsIsToldWhichResolutionFits) {
  MemoryLedger ledger(1000 * kMegabyte);
  FrameMemory memory(ledger, {"here", "me"}, kMostVoxels);
  ASSERT_TRUE(memory.receive(1).ok());
  const absl::Status status = memory.segment(frame_of(100'000, kMostVoxels + 1));
  EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
  const wire::ErrorDetails details = wire::details_of(status);
  EXPECT_EQ(details.reason, wire::ErrorReason::kLimitExceeded);
  EXPECT_EQ(details.metadata.at("limit"), "max_voxels");
  EXPECT_EQ(details.metadata.at("voxel_resolution"), "2e-05");
  EXPECT_THAT(std::string(status.message()), HasSubstr("a voxel_resolution of 2e-05 m would fit"));
}

TEST(FrameMemory, AFrameLargerThanTheBudgetIsRefusedForGood) {
  MemoryLedger ledger(20 * kMegabyte);
  FrameMemory memory(ledger, {"here", "me"}, kMostVoxels);
  ASSERT_TRUE(memory.receive(1).ok());
  const absl::Status status = memory.segment(frame_of(100'000, 40'000));
  const wire::ErrorDetails details = wire::details_of(status);
  EXPECT_EQ(details.reason, wire::ErrorReason::kLimitExceeded) << status;
  EXPECT_EQ(details.metadata.at("limit"), "memory_bytes");
  EXPECT_TRUE(details.metadata.contains("voxel_resolution"));
  EXPECT_FALSE(details.retry_delay);
  const absl::Status payload = FrameMemory(ledger, {"here", "me"}, kMostVoxels).receive(21 * kMegabyte);
  EXPECT_EQ(wire::details_of(payload).reason, wire::ErrorReason::kLimitExceeded) << payload;
}

TEST(FrameMemory, AFrameThatFitsLaterIsToldToComeAgain) {
  MemoryLedger ledger(20 * kMegabyte);
  const auto others = ledger.lease({"elsewhere", "others"}, 15 * kMegabyte);
  FrameMemory memory(ledger, {"here", "me"}, kMostVoxels);
  const absl::Status status = memory.receive(6 * kMegabyte);
  EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
  EXPECT_EQ(wire::details_of(status).reason, wire::ErrorReason::kQueueFull);
  EXPECT_TRUE(wire::details_of(status).retry_delay);
}

}  // namespace
}  // namespace segserve::server
