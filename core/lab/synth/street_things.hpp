// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/lab/synth/household.hpp"

/// Things on a street. Each stands on z = 0, centered on the z axis; its front faces +x.
namespace segserve::synth {

HouseholdObject random_car(Random& random);         ///< A body with a rounded nose and tail, a cabin, four wheels.
HouseholdObject random_van(Random& random);         ///< A box with a rounded front and four wheels.
HouseholdObject random_pedestrian(Random& random);  ///< Round parts, 1.5 to 1.95 m tall.
HouseholdObject random_lamp_post(Random& random);   ///< A pole of 5 to 8 m with an arm; it covers only its foot.

/// A tree. The last `crown` of its parts are leaves.
struct Tree {
  HouseholdObject body;  ///< It covers only the foot of the trunk.
  std::size_t crown = 0;
};
Tree random_tree(Random& random);

}  // namespace segserve::synth
