#pragma once

#include <vector>

#include "core/lab/synth/arrangement.hpp"
#include "core/lab/synth/household.hpp"

namespace segserve::synth {

/// A piece of furniture in its own frame: it stands on z = 0, its back towards -y.
struct Furniture {
  Household body;
  std::vector<Shelf> shelves;  ///< where objects can be put, in the same frame
};

Furniture random_table(Random& random);
Furniture random_chair(Random& random);      ///< four thin legs, a seat, a back
Furniture random_bookcase(Random& random);   ///< open boards on several heights
Furniture random_sideboard(Random& random);  ///< a closed body with doors
Furniture random_armchair(Random& random);

}  // namespace segserve::synth
