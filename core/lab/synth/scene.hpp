// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"
#include "segserve/codec/rgbd.hpp"

/// Synthetic scenes with ground truth. The same options give the same bytes on every machine and with every
/// compiler: there is no libm function but sqrt, and no distribution of <random>.
namespace segserve::synth {

/// The kind of sensor that measures the depths of a camera's frame.
enum class Sensor : std::uint8_t {
  kKinect1,        ///< Structured light: disparity steps of z^2 / 315 m, frayed borders, shadows of the projector.
  kStereo,         ///< Two cameras and a projector of texture: waves that grow with z^2, thickened edges, holes.
  kPassiveStereo,  ///< Two cameras: worse, and with larger holes, where surfaces have no texture.
  kTimeOfFlight,   ///< White noise where little light comes back, points that fly at edges, rounded corners.
  kIdeal,          ///< Exact depths at every pixel, whatever the noise; only colors have noise.
};

/// One frame of a camera that looks down at a table with household objects.
struct SceneOptions {
  std::uint64_t seed = 1;      ///< Seed of everything that is random.
  std::uint32_t width = 640;   ///< Pixels, 16 to 4096. The focal length is 525 * width / 640 pixels.
  std::uint32_t height = 480;  ///< Pixels, 16 to 4096.
  std::uint32_t objects = 8;   ///< 0 to 40. Fewer are placed when the table is full.
  double stacked = 0.25;       ///< Share of the objects that are placed on others, [0, 1].
  double clutter = 0.5;        ///< 0: spread over the table; 1: crowded, so that objects hide one another.
  bool compact = false;        ///< Only objects without cavities and thin parts: boxes, books, cans, bottles, balls.
  bool hollow = false;         ///< Only hollow and thin objects: bowls, cups, mugs, open boxes, plates, cables.
  Sensor sensor = Sensor::kKinect1;
  double noise = 1.0;       ///< Factor on the noise of the sensor and of the colors, [0, 10].
  double distance = 1.0;    ///< Factor on the usual distance of the camera (0.8 to 1.3 m), [0.5, 3].
  bool holes = true;        ///< Points without depth, where the sensor cannot measure.
  bool all_finite = false;  ///< A room around the table and no holes: every pixel is a finite point.
};

/// One frame of a camera in a furnished room that looks across its longest way: floor, walls, ceiling and furniture,
/// from about 1 m to the far corner, 9 m away in the usual room.
struct RoomViewOptions {
  std::uint64_t seed = 1;      ///< Seed of everything that is random.
  std::uint32_t width = 640;   ///< Pixels, 16 to 4096. The focal length is 525 * width / 640 pixels.
  std::uint32_t height = 480;  ///< Pixels, 16 to 4096.
  double size = 2.2;           ///< Factor on the edges of a room of 3.3 m x 2.8 m, [0.7, 10].
  std::uint32_t objects = 8;   ///< Small objects per 9.2 m^2 of floor, 0 to 60.
  bool furnished = false;      ///< See RoomOptions.
  Sensor sensor = Sensor::kKinect1;
  double noise = 1.0;  ///< Factor on the noise of the sensor and of the colors, [0, 10].
  bool holes = true;   ///< Points without depth, where the sensor cannot measure.
};

/// A room that is seen by many virtual cameras and fused into one surface, as KinectFusion does.
struct RoomOptions {
  std::uint64_t seed = 1;  ///< Seed of everything that is random.
  /// The exact number of points, 1000 to 20 million. They are about 7 mm * size * sqrt(600000 / points) apart.
  std::uint32_t points = 600000;
  double size = 1.0;           ///< Factor on the edges of the usual room, 3.3 m x 2.8 m, [0.7, 10].
  std::uint32_t objects = 16;  ///< Small objects per 9.2 m^2 of floor (size 1), 0 to 60.
  /// More kinds of furniture, besides tables, chairs, bookcases, sideboards and armchairs: sofas, beds, desks, office
  /// chairs, stools and floor lamps.
  bool furnished = false;
  double noise = 1.0;  ///< Factor on the noise of a Kinect v1 in each view, [0, 10].
};

/// One turn of a spinning LiDAR, in a furnished room or on a street. A point has no color.
struct LidarOptions {
  std::uint64_t seed = 1;        ///< Seed of everything that is random.
  std::uint32_t rings = 32;      ///< 16, 32, 64 or 128, with the fields of view of usual sensors.
  std::uint32_t columns = 1800;  ///< Directions a turn, 64 to 8192.
  bool street = false;           ///< A street with facades, cars, pedestrians, posts and trees, instead of a room.
  bool organized = false;     ///< One row a ring, NaN where there is no echo; else only the points, in order of time.
  double size = 1.6;          ///< Factor on the edges of a room of 3.3 m x 2.8 m, [0.7, 10].
  std::uint32_t objects = 4;  ///< Small objects per 9.2 m^2 of floor of the room, 0 to 60.
  bool furnished = false;     ///< See RoomOptions; for a room.
  double noise = 1.0;         ///< Factor on the noise of the range, 1.5 cm, [0, 10].
};

/// A scene with ground truth. The label of a point is 0 if it is not finite or lies on no surface, 1 on the table or
/// the floor, 2 to 9 on other support such as walls, and 20, 30, 40 and so on on objects, furniture included. In frames
/// of cameras, visible parts of an object that do not touch in the image have labels of their own, 20, 21, 22 and so
/// on, as in OSD's ground truth.
struct SyntheticScene {
  Cloud cloud;
  std::vector<std::uint32_t> label;         ///< One per point.
  std::optional<codec::Intrinsics> camera;  ///< The camera that took the frame, if one did.
};

/// Makes an organized cloud in the CAMERA view, row by row. Pixels without depth are NaN and keep their color.
/// INVALID_ARGUMENT that names every option out of its range.
absl::StatusOr<SyntheticScene> make_tabletop(const SceneOptions& options);

/// Makes a frame as make_tabletop does.
absl::StatusOr<SyntheticScene> make_room_view(const RoomViewOptions& options);

/// Makes a cloud in meters in the WORLD view. z is up, and the sensor is at the origin: 1.7 m above the ground of a
/// street (label 1, facades have labels 2 to 9), 1 to 1.9 m above the floor of a room. Objects of which fewer than ten
/// points are seen have label 0. INVALID_ARGUMENT that names every option out of its range.
absl::StatusOr<SyntheticScene> make_lidar_sweep(const LidarOptions& options);

/// Makes an unorganized cloud in meters in the WORLD view. z is up, the floor is at z = 0, the center of the room is at
/// x = y = 0, and the sensor is at the mean position of the virtual cameras. Every point is finite. Time and memory are
/// proportional to the number of points. INVALID_ARGUMENT that names every option out of its range.
absl::StatusOr<SyntheticScene> make_fused_room(const RoomOptions& options);

/// INVALID_ARGUMENT that names every option out of its range.
absl::Status check(const SceneOptions& options);
absl::Status check(const RoomViewOptions& options);
absl::Status check(const RoomOptions& options);
absl::Status check(const LidarOptions& options);

}  // namespace segserve::synth
