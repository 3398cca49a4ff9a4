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
Furniture random_sofa(Random& random);          ///< An armchair for two or three, with a cushion for each.
Furniture random_bed(Random& random);           ///< A frame with a headboard, a mattress and a pillow.
Furniture random_desk(Random& random);          ///< A top on a block of drawers and a side panel.
Furniture random_office_chair(Random& random);  ///< A seat and a back on a column and five arms.
Furniture random_stool(Random& random);         ///< A round seat on three legs.
Furniture random_floor_lamp(Random& random);    ///< A thin pole with a foot and a shade that is open below and above.

}  // namespace segserve::synth
