// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/prometheus_text.hpp"

#include <cmath>

#include "client/load_test/metrics_page.hpp"
#include "client/load_test/server_metrics.hpp"
#include "gmock/gmock.h"

namespace segserve::bench {
namespace {

TEST(PrometheusText, IsReadAsItsFormatSays) {
  const auto samples = parse_prometheus_text(
      "# HELP a A counter.\n# TYPE a counter\na 3\n"
      "b{x=\"1\",y=\"quote \\\" slash \\\\ end\\n\",} 4.5 1395066363000\n"
      "c_bucket{ le = \"+Inf\" } +Inf\r\n\n"
      "broken{x=\"1\nbroken}\n{} 1\nbroken one\nlast 1e-3");
  ASSERT_EQ(samples.size(), 4U);
  EXPECT_EQ(samples[0].text(), "a");
  EXPECT_EQ(samples[0].value, 3);
  EXPECT_EQ(samples[1].labels.at("y"), "quote \" slash \\ end\n");
  EXPECT_EQ(samples[1].value, 4.5);
  EXPECT_TRUE(std::isinf(samples[2].value));
  EXPECT_EQ(samples[3].value, 0.001);
}

TEST(PrometheusText, NoBytesBreakTheReader) {
  const std::string page = "b{x=\"1\",y=\"\\\\\"} 4.5\na 1\n";
  for (std::size_t i = 0; i < page.size(); ++i) {
    EXPECT_LE(parse_prometheus_text(page.substr(i)).size(), 2U);
    EXPECT_LE(parse_prometheus_text(page.substr(0, i)).size(), 2U);
    std::string changed = page;
    for (const char c : {'"', '{', '\\', '\0'}) {
      changed[i] = c;
      EXPECT_LE(parse_prometheus_text(changed).size(), 2U);
    }
  }
}

TEST(ServerMetrics, TellsWhatGrewAndItsPercentiles) {
  ServerMetrics metrics;
  metrics.before = parse_prometheus_text(
      "process_cpu_seconds_total 1\nsegserve_frames_total{call=\"stream\",outcome=\"result\"} 10\n"
      "r{cause=\"full\"} 2\nr{cause=\"late\"} 5\nw_bucket{le=\"0.1\"} 5\nw_bucket{le=\"0.2\"} 5\nw_bucket{le=\"+Inf\"} "
      "5\n");
  metrics.after = parse_prometheus_text(
      "process_cpu_seconds_total 3\nsegserve_frames_total{call=\"stream\",outcome=\"result\"} 110\n"
      "segserve_frames_total{call=\"stream\",outcome=\"failed\"} 7\n"
      "r{cause=\"full\"} 6\nr{cause=\"late\"} 5\nw_bucket{le=\"0.1\"} 5\nw_bucket{le=\"0.2\"} "
      "85\nw_bucket{le=\"+Inf\"} 105\n");
  EXPECT_EQ(metrics.growth("segserve_frames_total"), 107);
  EXPECT_EQ(*metrics.cpu_ms_per_frame(), 20);
  EXPECT_THAT(metrics.growth_by("r", "cause"), testing::ElementsAre(testing::Pair("full", 4)));
  EXPECT_NEAR(*metrics.percentile("w", 50), 0.1625, 1e-9);  // 50 of the 80 between 0.1 and 0.2
  EXPECT_NEAR(*metrics.percentile("w", 99), 0.2, 1e-9) << "the buckets tell no more";
  EXPECT_FALSE(metrics.percentile("nothing", 50));
  EXPECT_FALSE(ServerMetrics{}.cpu_ms_per_frame());
}

TEST(MetricsAddress, HasSeveralSpellings) {
  EXPECT_EQ(parse_metrics_address("http://robot:9464/metrics")->host, "robot");
  EXPECT_EQ(parse_metrics_address("robot:9464")->path, "/metrics");
  EXPECT_EQ(parse_metrics_address("[::1]:9464/x")->host, "::1");
  EXPECT_EQ(parse_metrics_address("http://[::1]:9464/x")->path, "/x");
  for (const char* wrong : {"", "robot", "https://robot:1/x", "robot:", ":1", "robot:x", "robot:1/a b"}) {
    EXPECT_TRUE(absl::IsInvalidArgument(parse_metrics_address(wrong).status())) << wrong;
  }
}

}  // namespace
}  // namespace segserve::bench
