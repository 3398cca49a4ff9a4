// SPDX-License-Identifier: Apache-2.0
#include "core/math/symmetric_matrix3.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>

namespace segserve {
namespace {

TEST(SmallestEigenvector, AgreesWithEigenOnPlanarPatches) {
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 2000; ++trial) {
    // A flat patch in a random rotation, whose thickness goes down to 0.
    const double thickness = trial % 10 == 0 ? 0 : std::pow(10.0, -(trial % 7));
    const Eigen::Quaterniond q =
        Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random)).normalized();
    const Eigen::Vector3d spread(1, 0.3, 0.2 * thickness);
    const Eigen::Matrix3d r = q.toRotationMatrix();
    const Eigen::Matrix3d a = r * spread.cwiseAbs2().asDiagonal() * r.transpose();
    const Vec3 n = smallest_eigenvector({a(0, 0), a(0, 1), a(0, 2), a(1, 1), a(1, 2), a(2, 2)});
    const Eigen::Vector3d expected = r.col(2);
    EXPECT_NEAR(std::fabs(n.x * expected.x() + n.y * expected.y() + n.z * expected.z()), 1, 1e-9) << thickness;
    EXPECT_NEAR(norm(n), 1, 1e-12);
  }
}

TEST(SmallestEigenvector, IsZeroForALineAndAPoint) {
  EXPECT_EQ(smallest_eigenvector(outer({1, 2, 3})), Vec3{});
  EXPECT_EQ(smallest_eigenvector({}), Vec3{});
}

TEST(SmallestEigenvector, DoesNotDependOnTheScale) {
  const Symmetric3 a{2, 0.3, 0.1, 1, 0.2, 0.05};
  const Vec3 n = smallest_eigenvector(a);
  const Vec3 tiny = smallest_eigenvector(1e-12 * a);
  EXPECT_NEAR(std::fabs(dot(n, tiny)), 1, 1e-12);
}

}  // namespace
}  // namespace segserve
