#include "core/merging/below_threshold.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/math/elementary.hpp"

namespace segserve {
namespace {

double sigmoid(double x) { return 1 / (1 + math::exp(-std::clamp(x, -700.0, 700.0))); }

TEST(BelowThreshold, SaysWhatTheWeightSays) {
  for (const double threshold : {0.0, 1e-300, 1e-12, 0.25, 0.5, 0.94, 1 - 1e-15, 1.0}) {
    const BelowThreshold below(sigmoid, threshold);
    const double crossing = threshold > 0 && threshold < 1 ? -math::ln(1 / threshold - 1) : 0;
    for (const double middle : {0.0, crossing, -690.0, 36.7}) {
      for (int step = -200; step <= 200; ++step) {
        for (const double size : {1e-15, 1e-10, 1e-8, 0.1}) {
          const double d = middle + step * size;
          EXPECT_EQ(below(sigmoid, d), sigmoid(d) < threshold) << threshold << ", " << d;
        }
      }
    }
  }
}

TEST(BelowThreshold, HoldsHoweverFarAway) {
  for (const double threshold : {0.0, 1e-305, 0.5, 1.0, 2.0}) {
    const BelowThreshold below(sigmoid, threshold);
    for (const double d : {-1e6, -2000.0, -1000.0, 1000.0, 2000.0, 1e6}) {
      EXPECT_EQ(below(sigmoid, d), sigmoid(d) < threshold) << threshold << ", " << d;
    }
  }
}

TEST(BelowThreshold, SeldomAsksForTheWeight) {
  int asked = 0;
  const auto weight = [&](double d) { return ++asked, sigmoid(d); };
  const BelowThreshold below(weight, 0.5);
  asked = 0;
  for (int i = -1000; i <= 1000; ++i) (void)below(weight, 0.01 * i);
  EXPECT_EQ(asked, 1) << "at the threshold itself";
}

}  // namespace
}  // namespace segserve
