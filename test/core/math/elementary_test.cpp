#include "core/math/elementary.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace segserve::math {
namespace {

// libm is the oracle here; only core itself must not depend on it.
TEST(Elementary, AgreesWithLibmToAFewUnitsInTheLastPlace) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 20000; ++i) {
    const double positive = std::exp(40 * unit(random) - 20);
    const double angle = 40 * unit(random) - 20;
    EXPECT_NEAR(ln(positive), std::log(positive), 1e-15 * (1 + std::fabs(std::log(positive))));
    EXPECT_NEAR(exp(angle) / std::exp(angle), 1, 2e-15);
    EXPECT_NEAR(cbrt(positive) / std::cbrt(positive), 1, 1e-15);
    EXPECT_NEAR(sin(angle), std::sin(angle), 4e-15);
    EXPECT_NEAR(cos(angle), std::cos(angle), 4e-15);
  }
}

TEST(Elementary, PowerAgreesWithLibm) {
  for (double x = 0.001; x < 1; x += 0.001) EXPECT_NEAR(pow(x, 2.4) / std::pow(x, 2.4), 1, 5e-15);
}

TEST(Elementary, ArcTangentKnowsItsQuadrant) {
  for (double angle = -3.14; angle < 3.14; angle += 0.01) {
    const double radius = 1 + angle * angle;
    EXPECT_NEAR(atan2(radius * std::sin(angle), radius * std::cos(angle)), angle, 2e-15);
  }
  EXPECT_EQ(atan2(0, 0), 0);
  EXPECT_DOUBLE_EQ(atan2(0, -1), kPi);
  EXPECT_DOUBLE_EQ(atan2(-1, 0), -kPi / 2);
}

TEST(Elementary, SinglePrecisionLogarithm) {
  for (float x = 1e-3F; x < 1e4F; x *= 1.0007F) {
    EXPECT_NEAR(ln(x), std::log(x), 3e-7F * (1 + std::fabs(std::log(x)))) << x;
  }
  EXPECT_EQ(ln(1.0F), 0.0F);
}

TEST(Elementary, SinglePrecisionExponential) {
  for (float x = -80; x <= 80; x += 0.0137F) EXPECT_NEAR(exp(x) / std::exp(x), 1, 1e-6F) << x;
  EXPECT_EQ(exp(0.0F), 1.0F);
}

TEST(Elementary, FloorGoesDownOnBothSidesOfZero) {
  EXPECT_EQ(floor_to_int(1.5F), 1);
  EXPECT_EQ(floor_to_int(-1.5F), -2);
  EXPECT_EQ(floor_to_int(-2.0F), -2);
  EXPECT_EQ(floor_to_int(0.0F), 0);
  EXPECT_EQ(floor_to_int(-1e-30), -1);
}

}  // namespace
}  // namespace segserve::math
