// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/lab/synth/household.hpp"

namespace segserve::synth {

/// The places that are occupied, so that things do not intersect. Each thing counts as the upright box around it,
/// rotated about the vertical.
class Arrangement {
 public:
  /// The upright box around a thing.
  struct Footprint {
    double x = 0, y = 0;            ///< Its center, in meters.
    double turns = 0;               ///< Rotation about the vertical, in full turns.
    double half_x = 0, half_y = 0;  ///< Half extents along its own axes, in meters.
    double bottom = 0, top = 0;     ///< Heights above z = 0, in meters.
  };

  /// True if nothing is closer to the footprint than `gap` meters, measured horizontally.
  bool is_free(const Footprint& footprint, double gap) const;
  void occupy(const Footprint& footprint) { occupied_.push_back(footprint); }
  const std::vector<Footprint>& occupied() const { return occupied_; }

 private:
  std::vector<Footprint> occupied_;
};

/// A horizontal rectangle on which objects can be placed.
struct Shelf {
  Pose pose;                ///< Its origin is the center; x and y span the rectangle, z points up.
  double half_x, half_y;    ///< Half extents in meters; objects stay within them.
  double clearance = 1e30;  ///< Free height above it, in meters.
};

/// How objects are placed.
struct PlacementOptions {
  double gap = 0.02;   ///< Least horizontal distance between things, in meters.
  double stacked = 0;  ///< Share of the objects that are placed on others, [0, 1].
  HouseholdObject (*make)(Random&) = random_household_object;
};

/// Places up to `count` random objects on the shelf, or on one another, so that none intersects anything, and appends
/// their solids to the world. Labels count up from `label` in steps of 10. Returns the next free label.
std::uint32_t place_objects(std::uint32_t count, const Shelf& shelf, const PlacementOptions& options,
                            std::uint32_t label, Random& random, Arrangement& arrangement, World& world);

}  // namespace segserve::synth
