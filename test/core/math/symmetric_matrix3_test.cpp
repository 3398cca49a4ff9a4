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
    // A random rotation of a flat patch whose thickness goes down to nothing.
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

TEST(SmallestEigenvector, IsUndefinedForALineAndAPoint) {
  EXPECT_EQ(smallest_eigenvector(outer({1, 2, 3})), Vec3{});
  EXPECT_EQ(smallest_eigenvector({}), Vec3{});
}

TEST(SmallestEigenvector, DoesNotDependOnTheScale) {
  const Symmetric3 a{2, 0.3, 0.1, 1, 0.2, 0.05};
  const Vec3 n = smallest_eigenvector(a);
  const Vec3 tiny = smallest_eigenvector(1e-12 * a);
  EXPECT_NEAR(std::fabs(dot(n, tiny)), 1, 1e-12);
}

TEST(PrincipalAxes, AgreeWithEigenOnRandomMatrices) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 2000; ++trial) {
    const Eigen::Quaterniond q =
        Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random)).normalized();
    const Eigen::Matrix3d r = q.toRotationMatrix();
    const double flat = trial % 5 == 0 ? 0 : std::pow(10.0, -(trial % 4));
    const Eigen::Matrix3d a = r * Eigen::Vector3d(7, 3, flat).asDiagonal() * r.transpose();
    const auto axes = principal_axes({a(0, 0), a(0, 1), a(0, 2), a(1, 1), a(1, 2), a(2, 2)});
    for (int k = 0; k < 3; ++k) {
      const Vec3& axis = axes[static_cast<std::size_t>(k)];
      const Eigen::Vector3d got(axis.x, axis.y, axis.z);
      EXPECT_NEAR(std::fabs(got.dot(r.col(k))), 1, 1e-12);
      EXPECT_NEAR(got.norm(), 1, 1e-15);
      EXPECT_TRUE(k == 2 || got.cwiseAbs().maxCoeff() == got.maxCoeff()) << "the largest component is positive";
    }
    EXPECT_NEAR(dot(cross(axes[0], axes[1]), axes[2]), 1, 1e-14) << "right-handed";
    EXPECT_NEAR(dot(axes[0], axes[1]), 0, 1e-14);
  }
}

TEST(PrincipalAxes, AreThoseOfTheFrameWhereNoneIsBetter) {
  const std::array<Vec3, 3> frame{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  EXPECT_EQ(principal_axes({}), frame);
  EXPECT_EQ(principal_axes({4, 0, 0, 4, 0, 4}), frame);
  EXPECT_EQ(principal_axes({4, 0, 0, 4, 0, 1e-300}), frame);
}

TEST(PrincipalAxes, OfALineAreItselfAndAnyTwoAcross) {
  const auto axes = principal_axes(outer({-3, 1, 2}));
  EXPECT_NEAR(dot(axes[0], unit({3, -1, -2})), 1, 1e-15);
  EXPECT_NEAR(dot(axes[0], axes[1]), 0, 1e-15);
  EXPECT_NEAR(dot(cross(axes[0], axes[1]), axes[2]), 1, 1e-15);
}

}  // namespace
}  // namespace segserve
