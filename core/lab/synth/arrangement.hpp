#pragma once

#include <cstdint>
#include <vector>

#include "core/lab/synth/household.hpp"

namespace segserve::synth {

/// Where things stand: keeps them from intersecting each other. Each thing is taken for the upright
/// box around it, turned about the vertical.
class Arrangement {
 public:
  /// The upright box around a thing.
  struct Footprint {
    double x = 0, y = 0;            ///< centre, metres
    double turns = 0;               ///< about the vertical, of 360 degrees
    double half_x = 0, half_y = 0;  ///< along its own axes
    double bottom = 0, top = 0;     ///< heights
  };

  /// True if nothing is closer to the footprint than `gap` metres.
  bool free(const Footprint& footprint, double gap) const;
  void occupy(const Footprint& footprint) { taken_.push_back(footprint); }
  const std::vector<Footprint>& taken() const { return taken_; }

 private:
  std::vector<Footprint> taken_;
};

/// An area of a support on which objects can be put: an upright rectangle's ground.
struct Shelf {
  Pose pose;                ///< its centre; x and y span it, z points up
  double half_x, half_y;    ///< metres; objects stay within
  double clearance = 1e30;  ///< free height above it, metres
};

/// How objects are put.
struct Habits {
  double gap = 0.02;   ///< least distance between things, metres
  double stacked = 0;  ///< share of the objects that are put on others
};

/// Puts up to `count` random objects on the shelf (or on one another), none intersecting anything,
/// and appends their solids to the world. Labels count up from `label` in steps of 10; returns the
/// next free label.
std::uint32_t put_objects(std::uint32_t count, const Shelf& shelf, const Habits& habits, std::uint32_t label,
                          Random& random, Arrangement& arrangement, World& world);

}  // namespace segserve::synth
