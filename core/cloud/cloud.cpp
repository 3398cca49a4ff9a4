// SPDX-License-Identifier: Apache-2.0
#include "segserve/cloud.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "fmt/format.h"

namespace segserve {

void Cloud::resize(std::size_t points, bool color) {
  x.resize(points);
  y.resize(points);
  z.resize(points);
  rgb.resize(color ? points : 0);
}

BorrowingCloud::BorrowingCloud(Cloud owned, const CloudView& borrowed) : owned_(std::move(owned)), all_(owned_) {
  if (owned_.x.empty()) all_.x = borrowed.x;
  if (owned_.y.empty()) all_.y = borrowed.y;
  if (owned_.z.empty()) all_.z = borrowed.z;
  if (owned_.rgb.empty()) all_.rgb = borrowed.rgb;
}

Cloud BorrowingCloud::to_cloud() && {
  const auto own = [](auto& plane, const auto& all) {
    if (plane.empty()) plane.assign(all.begin(), all.end());
  };
  own(owned_.x, all_.x);
  own(owned_.y, all_.y);
  own(owned_.z, all_.z);
  own(owned_.rgb, all_.rgb);
  return std::move(owned_);
}

std::optional<std::string> fault_of_cameras(const View& view, std::optional<std::size_t> points) {
  const std::size_t count = view.cameras.size();
  if (count == 0) return std::nullopt;
  if (view.kind != ViewKind::kWorld) return "cameras need a WORLD view, but the view is CAMERA";
  if (view.sensor) return "the view has both a sensor and cameras, but may only have one of them";
  if (count > kMostCameras)
    return fmt::format("there are {} cameras, but at most {} are possible", count, kMostCameras);
  std::uint64_t sum = 0;
  for (std::size_t c = 0; c < count; ++c) {
    const auto& [camera_points, sensor] = view.cameras[c];
    if (camera_points == 0) return fmt::format("camera {} has no points", c);
    if (!is_finite(sensor[0], sensor[1], sensor[2])) return fmt::format("the position of camera {} is not finite", c);
    sum += camera_points;
  }
  if (points && sum != *points) {
    return fmt::format("the cameras have {} points together, but the cloud has {}", sum, *points);
  }
  return std::nullopt;
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
  if (const auto fault = fault_of_cameras(cloud.view, n)) return absl::InvalidArgumentError(*fault);
  return absl::OkStatus();
}

}  // namespace segserve
