// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "core/math/vec3.hpp"

// The public API has Eigen's vectors; what decides labels computes with Vec3, whose sums have one order on every CPU.
// Never include this in a unit that is compiled for AVX2: the linker could then choose AVX2 code for every CPU.
namespace segserve {

inline Eigen::Vector3d to_eigen(const Vec3& v) { return {v.x, v.y, v.z}; }
inline Vec3 to_vec3(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace segserve
