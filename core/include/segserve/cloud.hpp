// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"

namespace segserve {

/// Where the sensor is relative to the points. Normals are turned towards it, and convexity (eq. 7 of the paper)
/// depends on that. Every cloud says it; segserve::core never guesses it.
enum class ViewKind : std::uint8_t {
  /// Camera frame: z points forward, the sensor is at the origin, coordinates are in meters, and every finite point has
  /// z > 0. Voxels are cubes of (x/z, y/z, ln z), so that they grow with the distance as pixels do.
  kCamera,
  /// Any other frame, in meters: voxels are cubes of (x, y, z). With a sensor position, normals are turned towards it;
  /// the border method does so only where the sensor can have seen the surface. Without a position, normals are made
  /// consistent over each connected component, and most of a component then faces up (+z).
  kWorld,
};

/// The points that one of several cameras saw. They follow one another in the cloud.
struct CameraPoints {
  std::uint32_t points = 0;                          ///< their number, at least 1
  Eigen::Vector3f sensor = Eigen::Vector3f::Zero();  ///< position of the camera in the cloud's frame, meters
  bool operator==(const CameraPoints&) const = default;
};

/// The most cameras that a view may have.
inline constexpr std::size_t kMostCameras = 64;

struct View {
  ViewKind kind = ViewKind::kCamera;
  /// Position of the sensor in the cloud's frame, meters. Only a WORLD view without cameras may have one.
  std::optional<Eigen::Vector3f> sensor = std::nullopt;
  /// The cameras of a WORLD cloud that several of them saw at once, in the order of their points. The first
  /// cameras[0].points points are those of cameras[0], and so on; the numbers add up to N. Each normal is turned to the
  /// camera that saw the surface, and ranges are measured from there. Empty for all other clouds. merge_cameras
  /// (segserve/cameras.hpp) makes such a cloud.
  std::vector<CameraPoints> cameras = {};

  static View camera() { return {}; }
  static View world() { return {ViewKind::kWorld, std::nullopt}; }
  static View world(float x, float y, float z) { return {ViewKind::kWorld, Eigen::Vector3f(x, y, z)}; }
  static View of_cameras(std::vector<CameraPoints> seen_by) {
    return {ViewKind::kWorld, std::nullopt, std::move(seen_by)};
  }
  /// Whether it is known where the sensor of each point is.
  bool has_sensor() const { return kind == ViewKind::kCamera || sensor.has_value() || !cameras.empty(); }
  bool operator==(const View&) const = default;
};

/// Color as 0x00RRGGBB, 8 bits a channel, sRGB.
constexpr std::uint32_t pack_rgb(std::uint8_t r, std::uint8_t g, std::uint8_t b) {
  return std::uint32_t{r} << 16U | std::uint32_t{g} << 8U | std::uint32_t{b};
}
constexpr std::uint8_t red(std::uint32_t rgb) { return static_cast<std::uint8_t>(rgb >> 16U); }
constexpr std::uint8_t green(std::uint32_t rgb) { return static_cast<std::uint8_t>(rgb >> 8U); }
constexpr std::uint8_t blue(std::uint32_t rgb) { return static_cast<std::uint8_t>(rgb); }

/// A colored cloud in memory that it does not own: one plane per channel, N entries each.
struct CloudView {
  std::span<const float> x, y, z;      ///< meters; a point with any of them not finite is "not finite"
  std::span<const std::uint32_t> rgb;  ///< 0x00RRGGBB (the top byte is ignored); empty: no color
  std::uint32_t width = 0;             ///< width * height == N
  std::uint32_t height = 0;            ///< 1 for an unorganized cloud, else the rows of an image
  View view;

  std::size_t size() const { return x.size(); }
  bool has_color() const { return !rgb.empty(); }
};

/// A colored cloud that owns its planes (see CloudView for their meaning).
struct Cloud {
  std::vector<float> x, y, z;
  std::vector<std::uint32_t> rgb;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  View view;

  std::size_t size() const { return x.size(); }
  bool has_color() const { return !rgb.empty(); }
  void resize(std::size_t points, bool color);
  operator CloudView() const { return {x, y, z, rgb, width, height, view}; }  // NOLINT(google-explicit-constructor)
};

/// A cloud that owns some of its planes. The others lie in memory that it does not own, which must outlive it.
class BorrowingCloud {
 public:
  /// Owns all planes.
  BorrowingCloud(Cloud cloud) : owned_(std::move(cloud)), all_(owned_) {}  // NOLINT(google-explicit-constructor)
  /// Takes the planes that are empty in `owned` from `borrowed`, and the rest from `owned`.
  BorrowingCloud(Cloud owned, const CloudView& borrowed);
  // The view stays valid when the planes move, but not when they are copied.
  BorrowingCloud(BorrowingCloud&&) noexcept = default;
  BorrowingCloud& operator=(BorrowingCloud&&) noexcept = default;
  BorrowingCloud(const BorrowingCloud&) = delete;
  BorrowingCloud& operator=(const BorrowingCloud&) = delete;
  ~BorrowingCloud() = default;

  operator const CloudView&() const { return all_; }  // NOLINT(google-explicit-constructor)
  const CloudView* operator->() const { return &all_; }
  /// Copies the borrowed planes, so that the result owns all of them.
  Cloud to_cloud() &&;

 private:
  Cloud owned_;
  CloudView all_;
};

/// More points than this do not fit the 32-bit indices used everywhere.
inline constexpr std::size_t kMaxPoints = 0x7fffffff;

/// Whether the three coordinates are finite numbers. Tests their bits, without branches.
inline bool is_finite(float x, float y, float z) {
  constexpr std::uint32_t kExponent = 0x7f800000U;  // all ones: infinity or not a number
  const auto exponent = [](float v) { return std::bit_cast<std::uint32_t>(v) & kExponent; };
  return static_cast<bool>(static_cast<int>(exponent(x) != kExponent) & static_cast<int>(exponent(y) != kExponent) &
                           static_cast<int>(exponent(z) != kExponent));
}

/// What is wrong with the cameras of a view, or with their numbers of points if the cloud has so many; a sentence
/// without its end, or nothing. A view without cameras has no such fault.
std::optional<std::string> fault_of_cameras(const View& view, std::optional<std::size_t> points = std::nullopt);

/// INVALID_ARGUMENT if the cloud is empty or has more than kMaxPoints, its planes differ in length,
/// width * height is not its size, or the view contradicts itself or the number of points. Coordinates are checked by
/// the stage that reads them (Segmenter::segment).
absl::Status check_shape(const CloudView& cloud);

}  // namespace segserve
