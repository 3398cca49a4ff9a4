// SPDX-License-Identifier: Apache-2.0
#include "core/statistics/principal_axes.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>

namespace segserve {
namespace {

Eigen::Vector3d with_largest_component_positive(const Eigen::Vector3d& v) {
  Eigen::Index largest = 0;
  v.cwiseAbs().maxCoeff(&largest);
  return v[largest] < 0 ? Eigen::Vector3d(-v) : v;
}

}  // namespace

Eigen::Matrix3d principal_axes(const Eigen::Matrix3d& matrix) {
  // compute() needs no libm but sqrt, which IEEE 754 defines to the last bit; computeDirect() calls atan2 and cos.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(matrix);
  std::array<Eigen::Index, 3> order{0, 1, 2};
  std::ranges::stable_sort(
      order, [&solver](Eigen::Index a, Eigen::Index b) { return solver.eigenvalues()[a] > solver.eigenvalues()[b]; });
  const Eigen::Vector3d first = with_largest_component_positive(solver.eigenvectors().col(order[0]));
  const Eigen::Vector3d second = with_largest_component_positive(solver.eigenvectors().col(order[1]));
  Eigen::Matrix3d axes;
  axes << first, second, first.cross(second);
  return axes;
}

}  // namespace segserve
