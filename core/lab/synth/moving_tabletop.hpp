// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "core/lab/synth/scene.hpp"
#include "core/lab/synth/table_scene.hpp"
#include "segserve/tracking.hpp"

namespace segserve::synth {

/// A table that a camera sees over time.
struct MovingOptions {
  SceneOptions scene;          ///< The table, and how the camera measures; `distance` is that at the beginning.
  double rate = 10;            ///< Frames a second, [0.1, 120]. The motion is the same at any rate.
  std::uint32_t frames = 100;  ///< 1 to 100,000.
  double camera_motion = 1;    ///< Factor on the motion of the camera: 1 is about 0.2 m/s and 10 degrees/s, [0, 5].
  std::uint32_t moving = 2;    ///< How many objects slide over the table to and fro, at most as many as can, 0 to 40.
  double speed = 0.15;         ///< Their highest speed, m/s, [0, 2].
};

struct MovingFrame {
  /// As make_tabletop makes it, but that all visible parts of an object have the same label in all frames.
  SyntheticScene scene;
  double time = 0;      ///< Seconds since the first frame.
  RigidTransform pose;  ///< From the frame of the camera to that of the table, in which z is up.
};

/// The frames of a moving scene, each of which can be made by itself. Objects slide along straight lines without
/// touching others, and turn as they go; they stop at both ends. The camera goes around the table to and fro, nods and
/// comes closer.
class MovingTabletop {
 public:
  /// INVALID_ARGUMENT that names every option out of its range.
  static absl::StatusOr<MovingTabletop> make(const MovingOptions& options);

  std::uint32_t frames() const { return options_.frames; }
  /// How many objects move; no more may have found a way.
  std::size_t moving() const { return ways_.size(); }
  /// `index` is below frames().
  MovingFrame frame(std::uint32_t index) const;

 private:
  /// The way of an object to and fro.
  struct Way {
    std::uint32_t label = 0;
    Vec3 center;        ///< of the object, where it begins
    Vec3 along;         ///< to where it returns
    double turns = 0;   ///< by which it turns on the way
    double period = 1;  ///< seconds from the beginning and back
    double delay = 0;   ///< share of the period
  };

  explicit MovingTabletop(const MovingOptions& options) : options_(options), table_(arrange_table(options.scene)) {}
  void plan_ways();
  Camera camera_at(double seconds) const;
  World world_at(double seconds) const;

  MovingOptions options_;
  TableScene table_;
  std::vector<Way> ways_;
};

/// INVALID_ARGUMENT that names every option out of its range.
absl::Status check(const MovingOptions& options);

}  // namespace segserve::synth
