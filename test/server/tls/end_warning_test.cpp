// SPDX-License-Identifier: Apache-2.0
#include "server/tls/end_warning.hpp"

#include <chrono>

#include "gtest/gtest.h"

namespace segserve::server {
namespace {

using std::chrono::days, std::chrono::hours, std::chrono::seconds;

// 2026-01-01 00:00:00 UTC
constexpr std::chrono::sys_seconds kStart{seconds(1'767'225'600)};
constexpr tls::Validity kYear{.begin = kStart, .end = kStart + days(365)};

TEST(EndWarning, SaysNothingWhileTheCertificateLasts) {
  EndWarning warning("it");
  EXPECT_EQ(warning.due(kYear, kStart), std::nullopt);
  EXPECT_EQ(warning.due(kYear, kStart + days(334)), std::nullopt);
}

TEST(EndWarning, WarnsThirtyDaysBeforeTheEndAndAgainEachDay) {
  EndWarning warning("it");
  const auto month_before = kStart + days(335);
  EXPECT_EQ(warning.due(kYear, month_before), "it ends in 30 days, on 2027-01-01 00:00:00 UTC");
  EXPECT_EQ(warning.due(kYear, month_before + hours(23)), std::nullopt);
  EXPECT_EQ(warning.due(kYear, month_before + hours(24)), "it ends in 29 days, on 2027-01-01 00:00:00 UTC");
  EXPECT_EQ(warning.due(kYear, month_before + hours(25)), std::nullopt);
}

TEST(EndWarning, ACertificateOfOneDayIsAboutToEndInItsLastThird) {
  EndWarning warning("it");
  const tls::Validity day{.begin = kStart, .end = kStart + hours(24)};
  EXPECT_EQ(warning.due(day, kStart + hours(15)), std::nullopt);
  EXPECT_EQ(warning.due(day, kStart + hours(17)), "it ends in 7 hours, on 2026-01-02 00:00:00 UTC");
}

TEST(EndWarning, SaysAtOnceThatTheCertificateHasEnded) {
  EndWarning warning("it");
  EXPECT_NE(warning.due(kYear, kYear.end - seconds(1)), std::nullopt);
  EXPECT_EQ(warning.due(kYear, kYear.end), "it has ended on 2027-01-01 00:00:00 UTC: connections fail");
}

TEST(EndWarning, SaysThatTheCertificateIsNotValidYet) {
  EndWarning warning("it");
  EXPECT_EQ(warning.due(kYear, kStart - seconds(1)),
            "it is not valid before 2026-01-01 00:00:00 UTC: connections fail");
}

TEST(EndWarning, ANewCertificateEndsTheWarningsOrHasOneOfItsOwn) {
  EndWarning warning("it");
  const auto late = kYear.end - days(3);
  EXPECT_NE(warning.due(kYear, late), std::nullopt);
  EXPECT_EQ(warning.due({.begin = kStart, .end = kYear.end + days(365)}, late + hours(30)), std::nullopt);
  EXPECT_EQ(warning.due({.begin = kStart, .end = kYear.end + days(1)}, late + hours(31)),
            "it ends in 2 days, on 2027-01-02 00:00:00 UTC");
}

}  // namespace
}  // namespace segserve::server
