#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "absl/status/status.h"

namespace segserve {

/// Where the sensor is relative to the points. Normals are turned towards it, and convexity
/// (eq. 7 of the paper) depends on that, so every cloud says it; it is never guessed in core.
enum class ViewKind : std::uint8_t {
  /// Camera frame: z forward, in metres, the sensor at the origin; every finite point has z > 0.
  /// Voxels are cubes of (x/z, y/z, ln z), so that they grow with the distance as pixels do.
  kCamera,
  /// Any other frame: cubic voxels in metres. With a sensor position, normals are turned towards
  /// it (by the border method only those that it can have seen: orient_hidden); without one, they are made
  /// consistent over each connected component and turned upwards (+z) on the whole.
  kWorld,
};

struct View {
  ViewKind kind = ViewKind::kCamera;
  /// Position of the sensor in the cloud's frame, metres; WORLD only.
  std::optional<std::array<float, 3>> sensor = std::nullopt;

  static View camera() { return {}; }
  static View world() { return {ViewKind::kWorld, std::nullopt}; }
  static View world(float x, float y, float z) { return {ViewKind::kWorld, std::array<float, 3>{x, y, z}}; }
  /// Whether it is known where the sensor is.
  bool has_sensor() const { return kind == ViewKind::kCamera || sensor.has_value(); }
  bool operator==(const View&) const = default;
};

/// Colour as 0x00RRGGBB, 8 bits a channel, sRGB.
constexpr std::uint32_t pack_rgb(std::uint8_t r, std::uint8_t g, std::uint8_t b) {
  return std::uint32_t{r} << 16U | std::uint32_t{g} << 8U | std::uint32_t{b};
}
constexpr std::uint8_t red(std::uint32_t rgb) { return static_cast<std::uint8_t>(rgb >> 16U); }
constexpr std::uint8_t green(std::uint32_t rgb) { return static_cast<std::uint8_t>(rgb >> 8U); }
constexpr std::uint8_t blue(std::uint32_t rgb) { return static_cast<std::uint8_t>(rgb); }

/// A coloured cloud that somebody else owns: one plane per channel, N entries each.
struct CloudView {
  std::span<const float> x, y, z;      ///< metres; a point with any of them not finite is "not finite"
  std::span<const std::uint32_t> rgb;  ///< 0x00RRGGBB (the top byte is ignored); empty: no colour
  std::uint32_t width = 0;             ///< width * height == N
  std::uint32_t height = 0;            ///< 1 for an unorganised cloud, else rows of an image
  View view;

  std::size_t size() const { return x.size(); }
  bool has_color() const { return !rgb.empty(); }
};

/// A coloured cloud that owns its planes (see CloudView for their meaning).
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

/// A cloud that owns some of its planes; the others lie in memory of somebody else, which must outlive it.
class BorrowingCloud {
 public:
  /// All of it is owned.
  BorrowingCloud(Cloud cloud) : owned_(std::move(cloud)), all_(owned_) {}  // NOLINT(google-explicit-constructor)
  /// Planes that are empty in `owned` are those of `borrowed`; the rest is as in `owned`.
  BorrowingCloud(Cloud owned, const CloudView& borrowed);
  // The view stays valid when the planes move, but not when they are copied.
  BorrowingCloud(BorrowingCloud&&) noexcept = default;
  BorrowingCloud& operator=(BorrowingCloud&&) noexcept = default;
  BorrowingCloud(const BorrowingCloud&) = delete;
  BorrowingCloud& operator=(const BorrowingCloud&) = delete;
  ~BorrowingCloud() = default;

  operator const CloudView&() const { return all_; }  // NOLINT(google-explicit-constructor)
  const CloudView* operator->() const { return &all_; }
  /// With all planes in its own memory.
  Cloud to_cloud() &&;

 private:
  Cloud owned_;
  CloudView all_;
};

/// More points than this do not fit the 32-bit indices used everywhere.
inline constexpr std::size_t kMaxPoints = 0x7fffffff;

/// True if the three coordinates are finite numbers (tested on their bits, without branches).
inline bool is_finite(float x, float y, float z) {
  constexpr std::uint32_t kExponent = 0x7f800000U;  // all ones: infinity or not a number
  const auto exponent = [](float v) { return std::bit_cast<std::uint32_t>(v) & kExponent; };
  return static_cast<bool>(static_cast<int>(exponent(x) != kExponent) & static_cast<int>(exponent(y) != kExponent) &
                           static_cast<int>(exponent(z) != kExponent));
}

/// INVALID_ARGUMENT if the cloud is empty or has more than kMaxPoints, its planes differ in length,
/// width * height is not its size, or the view contradicts itself. Coordinates are checked where they are read
/// (voxelize).
absl::Status check_shape(const CloudView& cloud);

}  // namespace segserve
