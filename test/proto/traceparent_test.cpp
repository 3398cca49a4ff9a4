// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/traceparent.hpp"

#include <set>
#include <string>
#include <vector>

#include "gtest/gtest.h"

namespace segserve::wire {
namespace {

constexpr const char* kSampled = "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01";

TEST(Traceparent, IsReadAndWrittenBack) {
  const auto parsed = parse_traceparent(kSampled);
  ASSERT_TRUE(parsed);
  EXPECT_EQ(parsed->trace_id, "4bf92f3577b34da6a3ce929d0e0e4736");
  EXPECT_EQ(parsed->span_id, "00f067aa0ba902b7");
  EXPECT_TRUE(parsed->is_sampled);
  EXPECT_EQ(to_text(*parsed), kSampled);
}

TEST(Traceparent, HasOneFlagThatCounts) {
  const auto flags = [](const std::string& digits) {
    return parse_traceparent("00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-" + digits)->is_sampled;
  };
  EXPECT_FALSE(flags("00"));
  EXPECT_TRUE(flags("01"));
  EXPECT_FALSE(flags("02"));
  EXPECT_TRUE(flags("ff"));
}

TEST(Traceparent, IsIgnoredUnlessItIsExact) {
  const std::string good = kSampled;
  const std::string long_zero(32, '0'), short_zero(16, '0');
  const std::vector<std::string> all_bad = {
      std::string(),
      std::string("00"),
      good + "-",
      good + "-00",
      " " + good,
      good + "\n",
      good.substr(1),
      "01" + good.substr(2),
      "ff" + good.substr(2),                                      // other versions
      "00-4BF92F3577B34DA6A3CE929D0E0E4736-00f067aa0ba902b7-01",  // upper case
      "00-4bf92f3577b34da6a3ce929d0e0e473g-00f067aa0ba902b7-01",  // no digit
      "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-0x",  // no digit in the flags
      "00_4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01",  // other separators
      "00-4bf92f3577b34da6a3ce929d0e0e4736_00f067aa0ba902b7-01",
      "00-" + long_zero + "-00f067aa0ba902b7-01",
      "00-4bf92f3577b34da6a3ce929d0e0e4736-" + short_zero + "-01",
      std::string(55, '\0'),
      std::string(100'000, '0'),
  };
  for (const std::string& bad : all_bad) {
    EXPECT_FALSE(parse_traceparent(bad)) << bad.substr(0, 100);
  }
}

TEST(Traceparent, IsCheckedBeforeItIsSent) {
  EXPECT_TRUE(check_traceparent("").ok());
  EXPECT_TRUE(check_traceparent(kSampled).ok());
  const absl::Status wrong = check_traceparent("00-\n");
  EXPECT_EQ(wrong.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(wrong.message().find('\n'), absl::string_view::npos);
}

TEST(Traceparent, IsMadeOfRandomIdentifiers) {
  std::set<std::string> ids;
  for (int i = 0; i < 1000; ++i) {
    const Traceparent made{.trace_id = new_trace_id(), .span_id = new_span_id(), .is_sampled = true};
    EXPECT_TRUE(parse_traceparent(to_text(made))) << to_text(made);
    ids.insert(made.trace_id);
    ids.insert(made.span_id);
  }
  EXPECT_EQ(ids.size(), 2000U);
}

}  // namespace
}  // namespace segserve::wire
