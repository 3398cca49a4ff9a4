// SPDX-License-Identifier: Apache-2.0
#include "server/frames/frame_computation.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>

#include "fmt/format.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "proto/wire/status_message.hpp"

namespace segserve::server {
namespace {

constexpr std::uint64_t kMegabyte = 1'000'000;

/// A payload that is larger than it seems. It tells no more than that it goes beyond a limit, as compressed bytes do.
struct SurprisingPayload {
  std::string limit;
  std::uint64_t needed = 0;

  std::uint64_t attempts = 0, work = 0;  ///< so far; the work is the sum of the limits

  /// Decodes up to the limit. ABORTED stands for a success, because it ends the frame.
  absl::StatusOr<wire::DecodedCloud> decode(const codec::DecodeLimits& limits) {
    const std::uint64_t allowed = limit == "max_points" ? limits.max_points : limits.max_bytes;
    ++attempts;
    work += std::min(allowed, needed);
    if (allowed >= needed) return absl::AbortedError("decoded");
    return wire::with_details(absl::InvalidArgumentError("larger"),
                              {.reason = wire::ErrorReason::kLimitExceeded,
                               .metadata = {{"limit", limit}, {"actual", fmt::format("{}", allowed + 1)}}});
  }

  absl::Status compute(std::uint64_t budget) {
    MemoryLedger ledger(budget);
    FrameMemory memory(ledger, {"here", "me"}, 50'000);
    EXPECT_TRUE(memory.receive(27'000).ok());
    FrameSettings settings;
    settings.decode_limits = {.max_points = 16'000'000, .max_bytes = 4000 * kMegabyte};
    settings.max_time = std::chrono::minutes(1);
    const std::atomic<bool> cancelled = false;
    const auto backend = core_backend_factory()();
    FrameWork unused;
    return compute_frame([this](const codec::DecodeLimits& limits, const StopToken&) { return decode(limits); },
                         [](wire::Result&, const CloudView&) { return absl::UnimplementedError("no result"); },
                         settings, cancelled, *backend, memory, unused);
  }
};

TEST(FrameComputation, APayloadThatIsLargerThanItSeemedIsDecodedInFewAttempts) {
  for (const std::uint64_t needed : {kMegabyte, 300 * kMegabyte, 700 * kMegabyte, 950 * kMegabyte}) {
    SurprisingPayload payload{"max_decoded_bytes", needed};
    EXPECT_TRUE(absl::IsAborted(payload.compute(1000 * kMegabyte))) << needed;
    EXPECT_LE(payload.attempts, 20U) << needed;
    EXPECT_LE(payload.work, 5 * needed) << needed;
  }
  for (const std::uint64_t needed : {10'000U, 3'000'000U, 12'000'000U}) {
    SurprisingPayload payload{"max_points", needed};
    EXPECT_TRUE(absl::IsAborted(payload.compute(1000 * kMegabyte))) << needed;
    EXPECT_LE(payload.attempts, 20U) << needed;
    EXPECT_LE(payload.work, 5 * needed) << needed;
  }
}

TEST(FrameComputation, APayloadThatNeverFitsIsRefusedByTheMemory) {
  for (SurprisingPayload payload :
       {SurprisingPayload{"max_decoded_bytes", 2000 * kMegabyte}, {"max_points", 15'000'000}}) {
    const absl::Status status = payload.compute(256 * kMegabyte);
    EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
    EXPECT_EQ(wire::details_of(status).metadata.at("limit"), "memory_bytes") << status;
    EXPECT_LE(payload.attempts, 20U) << payload.limit;
  }
}

}  // namespace
}  // namespace segserve::server
