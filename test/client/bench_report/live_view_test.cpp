// SPDX-License-Identifier: Apache-2.0
#include "client/bench_report/live_view.hpp"

#include <limits>
#include <sstream>
#include <string>

#include "gmock/gmock.h"

namespace segserve::bench_report {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr LiveStyle kPlain{.columns = 100, .has_color = false, .has_unicode = true};

LiveSnapshot snapshot(double t, double p99) {
  LiveSnapshot made;
  made.t = t;
  made.offered = 60;
  made.results = 59;
  made.p50_ms = 29.72;
  made.p99_ms = p99;
  made.all_results = 1712;
  made.all_p50_ms = 30;
  made.all_p99_ms = 55;
  return made;
}

std::size_t longest_line(const std::string& text) {
  std::istringstream lines(text);
  std::size_t longest = 0;
  for (std::string line; std::getline(lines, line);) {
    std::size_t columns = 0;
    for (const char c : line) columns += (static_cast<unsigned char>(c) & 0xc0U) != 0x80U ? 1 : 0;
    longest = std::max(longest, columns);
  }
  return longest;
}

TEST(LiveView, ShowsTheRateThePercentilesAndASparkline) {
  LiveView view("4 clients, planar");
  view.set_progress(0.5);
  for (const double p99 : {10.0, 20.0, 40.0, 80.0}) view.add(snapshot(3, p99));
  EXPECT_EQ(view.lines(kPlain), R"(bench    50 % [###############---------------]  4 clients, planar
now     59.0 of 60.0 frames/s     p50   29.7  p99   80.0 ms  0 failed
so far  1712 results              p50   30.0  p99   55.0 ms  0 failed
p99     ▁▂▄█ 10.0 to 80.0 ms
)");
}

TEST(LiveView, BeforeTheFirstIntervalThereIsTheProgressOnly) {
  LiveView view("x");
  EXPECT_EQ(view.lines(kPlain), "bench     0 % [------------------------------]  x\n");
}

TEST(LiveView, TheWarmUpIsSaidAndNotCounted) {
  LiveView view("x");
  view.add(snapshot(-1, 10));
  EXPECT_THAT(view.lines(kPlain), HasSubstr("] warm-up  x\n"));
  EXPECT_THAT(view.lines(kPlain), Not(HasSubstr("so far")));
}

TEST(LiveView, AClosedLoopOffersNothing) {
  LiveView view("x");
  LiveSnapshot closed = snapshot(0, 10);
  closed.offered = 0;
  closed.seconds = 0.5;
  view.add(closed);
  EXPECT_THAT(view.lines(kPlain), HasSubstr("now     118.0 frames/s "));
}

TEST(LiveView, FailedFramesAreRedAndInfinitelyLate) {
  LiveView view("x");
  LiveSnapshot failing = snapshot(0, kInfinity);
  failing.failed = 41;
  view.add(snapshot(0, 10));
  view.add(failing);
  const std::string text = view.lines({.columns = 100, .has_color = true, .has_unicode = true});
  EXPECT_THAT(text, HasSubstr("\033[31m  41 failed (41 %)\033[0m"));
  EXPECT_THAT(text, HasSubstr("p99 infinite ms"));
  EXPECT_THAT(text, HasSubstr("██ 10.0 to 10.0 ms"));
  EXPECT_THAT(view.lines(kPlain), Not(HasSubstr("\033")));
}

TEST(LiveView, AnIntervalWithoutAResultHasNoBar) {
  LiveView view("x");
  LiveSnapshot stalled = snapshot(0, 10);
  stalled.p50_ms = stalled.p99_ms = std::nullopt;
  stalled.results = 0;
  view.add(snapshot(0, 10));
  view.add(stalled);
  view.add(snapshot(0, 10));
  EXPECT_THAT(view.lines(kPlain), HasSubstr("p99     █ █ 10.0"));
}

TEST(LiveView, EveryLineFitsIntoANarrowTerminal) {
  LiveView view("a title that is longer than a narrow terminal is wide");
  for (int i = 0; i < 1000; ++i) view.add(snapshot(i, 10 + i));
  for (const std::size_t columns : {1, 10, 20, 40, 60, 80, 200}) {
    EXPECT_LT(longest_line(view.lines({.columns = columns, .has_color = false})), columns) << columns;
  }
  EXPECT_THAT(view.lines({.columns = 40, .has_color = false}), HasSubstr("now     59.0 of 60.0 frames/s   \n"));
}

TEST(LiveView, WithoutUnicodeItIsAscii) {
  LiveView view("x");
  for (const double p99 : {10.0, 80.0}) view.add(snapshot(0, p99));
  EXPECT_THAT(view.lines({.columns = 80, .has_color = false, .has_unicode = false}), HasSubstr("p99     _# 10.0"));
}

TEST(LiveView, RedrawsInPlaceAndWipesWhatItDrew) {
  LiveView view("x");
  EXPECT_EQ(view.wipe(), "");
  EXPECT_EQ(view.redraw(kPlain), view.lines(kPlain));
  view.add(snapshot(0, 10));
  EXPECT_THAT(view.redraw(kPlain), StartsWith("\033[1A\r\033[Jbench"));
  EXPECT_EQ(view.wipe(), "\033[4A\r\033[J");
  EXPECT_EQ(view.wipe(), "");
}

TEST(LiveView, TitlesAreNoCommandsToTheTerminal) {
  EXPECT_THAT(LiveView("a\033[2Jb").lines(kPlain), HasSubstr("a?[2Jb"));
}

}  // namespace
}  // namespace segserve::bench_report
