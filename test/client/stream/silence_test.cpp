// SPDX-License-Identifier: Apache-2.0
#include "client/stream/silence.hpp"

#include "gtest/gtest.h"

namespace segserve::client {
namespace {

using std::chrono::milliseconds;
using Verdict = Silence::Verdict;

const Time kStart{std::chrono::hours(1)};

TEST(Silence, OneOfSeveralIsSuspectAfterASecondAndDeadAfterTheTimeout) {
  const SilenceLimits limits = hasty_silence_limits(milliseconds(5000), {});
  Silence silence(kStart);
  EXPECT_EQ(silence.due(limits), kStart + milliseconds(500));
  EXPECT_EQ(silence.check(limits, kStart + milliseconds(499)), Verdict::kFine);
  EXPECT_EQ(silence.check(limits, kStart + milliseconds(500)), Verdict::kProbe);
  EXPECT_FALSE(silence.is_suspect());
  EXPECT_EQ(silence.due(limits), kStart + milliseconds(1000));
  EXPECT_EQ(silence.check(limits, kStart + milliseconds(1000)), Verdict::kFine);
  EXPECT_TRUE(silence.is_suspect());
  EXPECT_EQ(silence.due(limits), kStart + milliseconds(5000));
  EXPECT_EQ(silence.check(limits, kStart + milliseconds(5000)), Verdict::kDead);
}

TEST(Silence, ASignOfLifeClearsTheSuspicion) {
  const SilenceLimits limits = hasty_silence_limits(milliseconds(5000), {});
  Silence silence(kStart);
  silence.check(limits, kStart + milliseconds(500));
  silence.check(limits, kStart + milliseconds(1000));
  silence.on_sign_of_life(kStart + milliseconds(2000));
  EXPECT_FALSE(silence.is_suspect());
  EXPECT_EQ(silence.due(limits), kStart + milliseconds(2500));
}

TEST(Silence, TheOnlyServerIsProbedAtHalfTheTimeout) {
  const SilenceLimits limits = silence_limits(milliseconds(5000));
  Silence silence(kStart);
  EXPECT_EQ(silence.check(limits, kStart + milliseconds(2499)), Verdict::kFine);
  EXPECT_EQ(silence.check(limits, kStart + milliseconds(2500)), Verdict::kProbe);
  EXPECT_EQ(silence.check(limits, kStart + milliseconds(4999)), Verdict::kFine);
  EXPECT_FALSE(silence.is_suspect());
  EXPECT_EQ(silence.check(limits, kStart + milliseconds(5000)), Verdict::kDead);
}

TEST(Silence, ShortTimeoutsAreHalved) {
  const SilenceLimits limits = hasty_silence_limits(milliseconds(400), {});
  EXPECT_EQ(limits.until_probe, milliseconds(200));
  EXPECT_EQ(limits.until_dead, milliseconds(200));
}

TEST(Silence, WhereFramesTakeLongAProbeMayTakeAsLong) {
  EXPECT_EQ(hasty_silence_limits(milliseconds(5000), milliseconds(20)).until_suspect, milliseconds(500));
  EXPECT_EQ(hasty_silence_limits(milliseconds(5000), milliseconds(2000)).until_suspect, milliseconds(2000));
  EXPECT_EQ(hasty_silence_limits(milliseconds(5000), milliseconds(9000)).until_suspect, milliseconds(4500));
}

TEST(Silence, ItIsNoFaultOfAServerThatThisProcessStoodStill) {
  SilenceClock clock;
  EXPECT_EQ(clock.check(kStart), milliseconds(0));
  clock.set_due(kStart + milliseconds(500));
  EXPECT_EQ(clock.check(kStart + milliseconds(600)), milliseconds(0)) << "threads start late now and then";
  const Clock::duration stood_still = clock.check(kStart + milliseconds(4000));
  EXPECT_EQ(stood_still, milliseconds(3500));

  const SilenceLimits limits = hasty_silence_limits(milliseconds(2000), {});
  Silence silence(kStart);
  silence.check(limits, kStart + milliseconds(500));
  silence.forgive(stood_still, kStart + milliseconds(4000));
  EXPECT_EQ(silence.check(limits, kStart + milliseconds(4000)), Verdict::kFine);
  EXPECT_FALSE(silence.is_suspect());
}

}  // namespace
}  // namespace segserve::client
