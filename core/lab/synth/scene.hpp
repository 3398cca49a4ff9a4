#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"

/// Synthetic RGB-D scenes with ground truth. The same options give the same bytes on every machine
/// and with every compiler: no libm function but sqrt, no distribution of <random>.
namespace segserve::synth {

/// One frame of a Kinect-like camera that looks down at a table with household objects.
struct SceneOptions {
  std::uint64_t seed = 1;      ///< everything that is random follows from it
  std::uint32_t width = 640;   ///< pixels, 16 to 4096; focal length = 525 * width / 640 pixels
  std::uint32_t height = 480;  ///< pixels, 16 to 4096
  std::uint32_t objects = 8;   ///< 0 to 40; fewer are placed when the table is full
  double stacked = 0.25;       ///< share of the objects that are put on top of others, [0, 1]
  double clutter = 0.5;        ///< 0: spread over the table, 1: crowded, so that objects hide one another
  double noise = 1.0;          ///< times the noise of a Kinect v1 (depth, disparity steps, colour), [0, 10]; 0: perfect
  double distance = 1.0;       ///< times the usual distance of the camera (0.8 to 1.3 m), [0.5, 3]
  bool holes = true;           ///< projector shadow, grazing angles, dark spots: points without depth
  bool all_finite = false;     ///< a room around the table and no holes: every pixel is a finite point
};

/// A room seen from many virtual views all around it, fused into one surface as KinectFusion does.
struct RoomOptions {
  std::uint64_t seed = 1;  ///< everything that is random follows from it
  std::uint32_t points =
      600000;                  ///< exactly so many, 1000 to 20 million; about 7 mm * size * sqrt(600000 / points) apart
  double size = 1.0;           ///< times the edges of the usual room, 3.3 m x 2.8 m, [0.7, 10]; furniture is as dense
  std::uint32_t objects = 16;  ///< small objects on tables and shelves per 9.2 m^2 of floor (size 1), 0 to 60
  double noise = 1.0;          ///< times the noise of a Kinect v1 in each view, [0, 10]; 0: perfect
};

/// Label of a point: 0 no finite point; 1 the table's top or the floor; 2..9 other support (walls, ..);
/// 20, 30, 40, .. objects, furniture included. Visible parts of one object that do not touch in
/// the image get labels of their own: 20, 21, .. (tabletop only, as in OSD's own ground truth).
struct SyntheticScene {
  Cloud cloud;
  std::vector<std::uint32_t> label;  ///< one per point
};

/// Organised cloud in the CAMERA view, row by row; pixels without depth are NaN with their colour
/// kept. INVALID_ARGUMENT naming every option out of its range.
absl::StatusOr<SyntheticScene> make_tabletop(const SceneOptions& options);

/// Unorganised cloud in metres, z up, floor at z = 0, the room's centre at x = y = 0; WORLD view with
/// the sensor at the mean position of the virtual cameras. Every point is finite. Time and memory
/// are proportional to the points. INVALID_ARGUMENT naming every option out of its range.
absl::StatusOr<SyntheticScene> make_fused_room(const RoomOptions& options);

/// OK, or INVALID_ARGUMENT naming every option out of its range.
absl::Status check(const SceneOptions& options);
absl::Status check(const RoomOptions& options);

}  // namespace segserve::synth
