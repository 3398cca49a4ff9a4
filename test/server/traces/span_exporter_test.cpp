// SPDX-License-Identifier: Apache-2.0
// See also test/e2e/test_traces.py, which tests what a collector receives.
#include "server/traces/span_exporter.hpp"

#include <memory>

#include "gtest/gtest.h"
#include "test/server/support/fake_backend.hpp"

namespace segserve::server {
namespace {

using namespace std::chrono_literals;

TracedFrame any_frame() {
  TracedFrame traced;
  traced.frame.caller = std::make_shared<Caller>();
  traced.trace = {.trace_id = "4bf92f3577b34da6a3ce929d0e0e4736", .parent_id = "", .span_id = "1111222233334444"};
  return traced;
}

/// Nobody listens there.
OtlpSettings nobody() { return otlp_settings("http://127.0.0.1:1").value(); }

TEST(SpanExporter, GivesUpOnACollectorThatIsNotThere) {
  SpanExporter exporter(nobody(), {.batch_delay = 1ms, .first_backoff = 1ms, .attempts = 2});
  for (int i = 0; i < 5; ++i) exporter.add(any_frame());
  EXPECT_TRUE(eventually([&] { return exporter.lost() == 5; }));
  EXPECT_EQ(exporter.exported(), 0U);
}

TEST(SpanExporter, KeepsABoundedNumberOfFramesAndEndsInTime) {
  constexpr std::uint64_t kFrames = 3000;
  const auto begin = std::chrono::steady_clock::now();
  {
    SpanExporter exporter(nobody(), {.batch_delay = 1ms, .first_backoff = 3600s, .flush_time = 50ms});
    for (std::uint64_t i = 0; i < kFrames; ++i) exporter.add(any_frame());
    EXPECT_GE(exporter.lost(), kFrames - SpanExporter::kMostWaiting - SpanExporter::kMostInBatch);
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 20s);
}

TEST(SpanExporter, EndsAtOnceWithNothingToSend) {
  const auto begin = std::chrono::steady_clock::now();
  { SpanExporter exporter(nobody(), {.batch_delay = 3600s}); }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 20s);
}

}  // namespace
}  // namespace segserve::server
