// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace segserve {

/// Unit eigenvectors of a positive semidefinite matrix, such as a covariance, as columns by descending eigenvalue. They
/// are right-handed: the largest component of the first two (the first such in the order x, y, z) is positive, and the
/// third is their cross product. Where eigenvalues are equal, any axes at right angles to the others serve; for a
/// multiple of the identity and for the zero matrix they are x, y and z.
///
/// Takes +, -, *, / and square roots in one order, so that the bytes of the result are the same on every CPU.
Eigen::Matrix3d principal_axes(const Eigen::Matrix3d& matrix);

}  // namespace segserve
