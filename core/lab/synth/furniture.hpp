// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/lab/synth/arrangement.hpp"
#include "core/lab/synth/household.hpp"

namespace segserve::synth {

/// A piece of furniture in its own frame: it stands on z = 0, and its back faces -y.
struct Furniture {
  HouseholdObject body;
  std::vector<Shelf> shelves;  ///< Where objects can be put, in the frame of the furniture.
};

Furniture random_table(Random& random);
Furniture random_chair(Random& random);      ///< Four thin legs, a seat and a back.
Furniture random_bookcase(Random& random);   ///< Open boards at several heights.
Furniture random_sideboard(Random& random);  ///< A closed body with doors.
Furniture random_armchair(Random& random);

}  // namespace segserve::synth
