// SPDX-License-Identifier: Apache-2.0
//
// libm is the oracle of these tests. Only core itself must not depend on it.
#define SEGSERVE_SIMD_TARGET elementary_test
#include "core/math/elementary.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/simd/elementary_functions.hpp"

namespace segserve::math {
namespace {

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

TEST(Elementary, FloorGoesDownOnBothSidesOfZero) {
  EXPECT_EQ(floor_to_int(1.5), 1);
  EXPECT_EQ(floor_to_int(-1.5), -2);
  EXPECT_EQ(floor_to_int(-2.0), -2);
  EXPECT_EQ(floor_to_int(0.0), 0);
  EXPECT_EQ(floor_to_int(-1e-30), -1);
}

namespace vectors = segserve::SEGSERVE_SIMD_TARGET;

/// A vector with other numbers in its other lanes.
vectors::Doubles with_first_lane(double value, double others) {
  vectors::Doubles v = others - vectors::Doubles{};
  v[0] = value;
  return v;
}

TEST(Elementary, IsTheSameInALaneOfAVectorWhateverTheOtherLanesHold) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 5000; ++i) {
    const double positive = std::exp(40 * unit(random) - 20), other = 3 * unit(random) + 0.1;
    const double angle = 40 * unit(random) - 20;
    EXPECT_DOUBLE_EQ(vectors::ln(with_first_lane(positive, other))[0], ln(positive));
    EXPECT_DOUBLE_EQ(vectors::exp(with_first_lane(angle, other))[0], exp(angle));
    EXPECT_DOUBLE_EQ(vectors::cbrt(with_first_lane(positive, other))[0], cbrt(positive));
    EXPECT_DOUBLE_EQ(vectors::pow(with_first_lane(positive, other), 0.3)[0], pow(positive, 0.3));
    EXPECT_NEAR(vectors::sin(with_first_lane(angle, other))[0], sin(angle), 1e-15);
    EXPECT_NEAR(vectors::cos(with_first_lane(angle, other))[0], cos(angle), 1e-15);
    EXPECT_DOUBLE_EQ(vectors::atan2(with_first_lane(angle, 0), with_first_lane(other - 2, 0))[0],
                     atan2(angle, other - 2));
  }
}

}  // namespace
}  // namespace segserve::math
