// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/lab/synth/solid.hpp"

namespace segserve::synth {

inline constexpr std::uint32_t kGround = 1;

/// A street along x. Its ground is at z = 0 (label 1; ground_height adds to it), facades have labels 2 to 9, and cars,
/// pedestrians, posts and trees one label each, 20, 30, 40 and so on. Nothing stands within 4 m of the z axis, which is
/// the place of the sensor.
struct StreetScene {
  World world;
  std::vector<double> depth_of_leaves;  ///< One per solid: how deep rays enter it, in meters; 0 if it is no crown.
  std::uint64_t seed = 0;
};

StreetScene arrange_street(std::uint64_t seed);

/// How much higher than z = 0 the ground is at a place, in meters: some centimeters up and down.
double ground_height(std::uint64_t seed, double x, double y);

}  // namespace segserve::synth
