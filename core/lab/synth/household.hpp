// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/lab/synth/solid.hpp"

namespace segserve::synth {

/// An object in its own frame: it stands on z = 0, centered on the z axis.
struct HouseholdObject {
  std::vector<Solid> parts;       ///< Their labels are set when the object is placed.
  double half_x = 0, half_y = 0;  ///< Half edges of the rectangle that it covers, in meters.
  double height = 0;              ///< Meters.
  double top_x = 0, top_y = 0;    ///< Half edges of the flat rectangle on its top; 0 if nothing can stand there.
};

/// A random household object, standing or lying, 4 to 30 cm large (up to 40 cm for a pan with its handle): boxes,
/// books, cans, tins, bottles, mugs, bowls, balls, fruit, flowerpots, cones, tape rolls, pans, candlesticks, poles.
HouseholdObject random_household_object(Random& random);

/// A random object whose surface is concave or thin: bowls, mugs with handles, cups, plates, open boxes with and
/// without flaps, cables, flowerpots, pans.
HouseholdObject random_hollow_object(Random& random);

/// A random object without cavities and thin parts: boxes, books, wooden blocks, cans, tins, bottles, balls, fruit.
HouseholdObject random_compact_object(Random& random);

}  // namespace segserve::synth
