#include "segserve/cloud/cloud.hpp"

#include "fmt/format.h"

namespace segserve {

void Cloud::resize(std::size_t points, bool color) {
  x.resize(points);
  y.resize(points);
  z.resize(points);
  rgb.resize(color ? points : 0);
}

absl::Status check_shape(const CloudView& cloud) {
  const std::size_t n = cloud.size();
  if (n == 0) return absl::InvalidArgumentError("the cloud is empty: it has no points");
  if (n > kMaxPoints) {
    return absl::InvalidArgumentError(fmt::format("the cloud has {} points; at most {} are possible", n, kMaxPoints));
  }
  if (cloud.y.size() != n || cloud.z.size() != n || (cloud.has_color() && cloud.rgb.size() != n)) {
    return absl::InvalidArgumentError(
        fmt::format("the planes of the cloud differ in length: x has {}, y {}, z {}, rgb {} entries", n, cloud.y.size(),
                    cloud.z.size(), cloud.rgb.size()));
  }
  if (std::uint64_t{cloud.width} * cloud.height != n) {
    return absl::InvalidArgumentError(
        fmt::format("width {} times height {} is not the number of points, {}", cloud.width, cloud.height, n));
  }
  if (cloud.view.sensor && cloud.view.kind == ViewKind::kCamera) {
    return absl::InvalidArgumentError("a CAMERA view has its sensor at the origin; give a position with WORLD only");
  }
  if (const auto& s = cloud.view.sensor; s && !is_finite((*s)[0], (*s)[1], (*s)[2])) {
    return absl::InvalidArgumentError("the position of the sensor is not finite");
  }
  return absl::OkStatus();
}

}  // namespace segserve
