#pragma once

#include <vector>

#include "core/lab/synth/solid.hpp"

namespace segserve::synth {

/// An object in its own frame: it stands on z = 0 about the z axis.
struct Household {
  std::vector<Solid> parts;       ///< labels are given when the object is placed
  double half_x = 0, half_y = 0;  ///< half edges of the rectangle it covers, metres
  double height = 0;
  double top_x = 0, top_y = 0;  ///< half edges of the flat rectangle on top of it; 0: nothing can stand there
};

/// A random household object, 4 to 30 cm large (a pan with its handle 40), standing or lying: boxes, books, cans, tins,
/// bottles, mugs, bowls, balls, fruit, flowerpots, cones, tape rolls, pans, candlesticks, poles.
Household random_household(Random& random);

}  // namespace segserve::synth
