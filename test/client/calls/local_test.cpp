// SPDX-License-Identifier: Apache-2.0
// A lack of memory in this process ends the frame, and neither the process nor the stream.
#include "client/calls/local.hpp"

#include <chrono>
#include <optional>
#include <string>
#include <utility>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "segserve/client/client.hpp"
#include "test/client/client_scenes.hpp"
#include "test/client/failing_memory.hpp"

namespace segserve::client {
namespace {

using testing::HasSubstr;

constexpr std::size_t kOneArrayOfALargeCloud = 1'000'000;  // bytes

TEST(Local, LackOfMemoryIsAStatus) {
  const Cloud cloud = flat_cloud(640, 480);
  std::optional<absl::Status> status;
  {
    const FailingMemory failing(kOneArrayOfALargeCloud);
    status = segment_here(cloud, "the origin", {}, {}, {}).status();
  }
  EXPECT_TRUE(absl::IsResourceExhausted(*status)) << *status;
  EXPECT_THAT(std::string(status->message()), HasSubstr("not enough memory to segment the cloud in this process"));
  EXPECT_TRUE(segment_here(cloud, "the origin", {}, {}, {}).ok());
}

TEST(Local, LackOfMemoryEndsOneFrameOfAStream) {
  const Client alone = *Client::connect({.address = "127.0.0.1:1"});
  StreamOptions options;
  options.fallback_to_local = true;
  options.frame_timeout = std::chrono::seconds(60);
  auto stream = alone.open_stream(options).value();
  const Cloud cloud = flat_cloud(640, 480);
  Payload large = cloud_payload(cloud).value();
  std::optional<Outcome> outcome;
  {
    const FailingMemory failing(kOneArrayOfALargeCloud);
    ASSERT_TRUE(stream.send(std::move(large)).ok());
    outcome = stream.next();
  }
  ASSERT_TRUE(outcome.has_value());
  EXPECT_EQ(outcome->kind, OutcomeKind::kFailed);
  EXPECT_TRUE(absl::IsResourceExhausted(outcome->status)) << outcome->status;

  ASSERT_TRUE(stream.send(flat_cloud(20, 20)).ok());
  outcome = stream.next();
  ASSERT_TRUE(outcome.has_value());
  EXPECT_EQ(outcome->kind, OutcomeKind::kResult) << outcome->status;
}

}  // namespace
}  // namespace segserve::client
