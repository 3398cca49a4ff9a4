// SPDX-License-Identifier: Apache-2.0
#include "core/statistics/principal_axes.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <bit>
#include <cmath>
#include <cstdint>
#include <random>

namespace segserve {
namespace {

TEST(PrincipalAxes, AreThoseThatTheMatrixWasMadeOf) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 2000; ++trial) {
    const Eigen::Quaterniond q =
        Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random)).normalized();
    const Eigen::Matrix3d r = q.toRotationMatrix();
    const double flat = trial % 5 == 0 ? 0 : std::pow(10.0, -(trial % 4));
    const Eigen::Matrix3d axes = principal_axes(r * Eigen::Vector3d(7, 3, flat).asDiagonal() * r.transpose());
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d axis = axes.col(k);
      EXPECT_NEAR(std::fabs(axis.dot(r.col(k))), 1, 1e-12);
      EXPECT_TRUE(k == 2 || axis.cwiseAbs().maxCoeff() == axis.maxCoeff()) << "the largest component is positive";
    }
    EXPECT_TRUE((axes.transpose() * axes).isIdentity(1e-14));
    EXPECT_NEAR(axes.determinant(), 1, 1e-14) << "right-handed";
  }
}

TEST(PrincipalAxes, AreThoseOfTheFrameWhereNoneIsBetter) {
  const Eigen::Matrix3d frame = Eigen::Matrix3d::Identity();
  EXPECT_EQ(principal_axes(Eigen::Matrix3d::Zero()), frame);
  EXPECT_EQ(principal_axes(4 * frame), frame);
}

TEST(PrincipalAxes, OfALineAreItsDirectionAndTwoAxesAcross) {
  const Eigen::Vector3d line(-3, 1, 2);
  const Eigen::Matrix3d axes = principal_axes(line * line.transpose());
  EXPECT_NEAR(axes.col(0).dot(-line.normalized()), 1, 1e-15);
  EXPECT_TRUE((axes.transpose() * axes).isIdentity(1e-14));
  EXPECT_NEAR(axes.determinant(), 1, 1e-14) << "right-handed";
}

TEST(PrincipalAxes, AreTheSameBytesOnEveryCpu) {
  std::mt19937_64 random(4);
  const auto number = [&random] { return static_cast<double>(static_cast<std::int64_t>(random())) / 0x1p63; };
  std::uint64_t hash = 0;
  for (int trial = 0; trial < 10'000; ++trial) {
    Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
    for (int i = 0; i < 3; ++i) {
      const double x = number(), y = trial % 3 == 0 ? x : number(), z = trial % 7 == 0 ? 0 : number();
      matrix.row(0) += Eigen::RowVector3d(x * x, x * y, x * z);
      matrix.row(1) += Eigen::RowVector3d(x * y, y * y, y * z);
      matrix.row(2) += Eigen::RowVector3d(x * z, y * z, z * z);
    }
    const Eigen::Matrix3d axes = principal_axes(matrix);
    for (const double value : axes.reshaped()) hash = 31 * hash + std::bit_cast<std::uint64_t>(value);
  }
  EXPECT_EQ(hash, 0x9c42568430e21eabU);
}

}  // namespace
}  // namespace segserve
