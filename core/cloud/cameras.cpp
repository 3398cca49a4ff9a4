// SPDX-License-Identifier: Apache-2.0
#include "segserve/cameras.hpp"

#include <Eigen/LU>
#include <cstddef>
#include <limits>
#include <utility>

#include "core/base/status_macros.hpp"
#include "fmt/format.h"

namespace segserve {
namespace {

/// The transform of one point. It computes in one order on every CPU.
Eigen::Vector3f transformed(const RigidTransform& pose, double x, double y, double z) {
  Eigen::Vector3f moved;
  for (Eigen::Index row = 0; row < 3; ++row) {
    const double sum =
        pose.rotation(row, 0) * x + pose.rotation(row, 1) * y + pose.rotation(row, 2) * z + pose.translation[row];
    moved[row] = static_cast<float>(sum);
  }
  return moved;
}

std::optional<std::string> fault_of_camera(const CameraCloud& camera, bool color) {
  const View& view = camera.cloud.view;
  if (const absl::Status shape = check_shape(camera.cloud); !shape.ok()) return std::string(shape.message());
  if (!view.cameras.empty()) return "the cloud is itself of several cameras";
  if (!view.has_sensor()) return "the cloud has a WORLD view that does not say where its sensor is";
  if (const auto fault = fault_of_transform(camera.pose)) return "the pose " + *fault;
  if (camera.cloud.has_color() != color) {
    return color ? "the cloud has no color, but that of camera 0 has"
                 : "the cloud has color, but that of camera 0 has none";
  }
  return std::nullopt;
}

absl::Status check(std::span<const CameraCloud> cameras) {
  if (cameras.empty()) return absl::InvalidArgumentError("there is no camera");
  if (cameras.size() > kMostCameras) {
    return absl::InvalidArgumentError(
        fmt::format("there are {} cameras, but at most {} are possible", cameras.size(), kMostCameras));
  }
  std::size_t points = 0;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    if (const auto fault = fault_of_camera(cameras[c], cameras[0].cloud.has_color())) {
      return absl::InvalidArgumentError(fmt::format("camera {}: {}", c, *fault));
    }
    points += cameras[c].cloud.size();
  }
  if (points > kMaxPoints) {
    return absl::InvalidArgumentError(
        fmt::format("the cameras have {} points together; at most {} are possible", points, kMaxPoints));
  }
  return absl::OkStatus();
}

void append(const CameraCloud& camera, Cloud& merged) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  const CloudView& cloud = camera.cloud;
  const bool zeros_are_missing = cloud.view.kind == ViewKind::kCamera;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const float x = cloud.x[i], y = cloud.y[i], z = cloud.z[i];
    const bool is_missing = !is_finite(x, y, z) || (zeros_are_missing && x == 0 && y == 0 && z == 0);
    const Eigen::Vector3f moved = is_missing ? Eigen::Vector3f::Constant(kNaN) : transformed(camera.pose, x, y, z);
    merged.x.push_back(moved.x());
    merged.y.push_back(moved.y());
    merged.z.push_back(moved.z());
  }
  merged.rgb.insert(merged.rgb.end(), cloud.rgb.begin(), cloud.rgb.end());
  const Eigen::Vector3f sensor = cloud.view.sensor.value_or(Eigen::Vector3f::Zero());
  merged.view.cameras.push_back(
      {static_cast<std::uint32_t>(cloud.size()), transformed(camera.pose, sensor.x(), sensor.y(), sensor.z())});
}

}  // namespace

std::optional<std::string> fault_of_transform(const RigidTransform& transform) {
  constexpr double kTolerance = 1e-3;
  const Eigen::Matrix3d& r = transform.rotation;
  if (!r.allFinite() || !transform.translation.allFinite()) return "is not finite";
  if ((r.transpose() * r - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > kTolerance) {
    return "has a rotation that is not orthonormal";
  }
  if (r.determinant() < 0) return "has a rotation that is left-handed, a mirror image";
  return std::nullopt;
}

absl::StatusOr<Cloud> merge_cameras(std::span<const CameraCloud> cameras) {
  RETURN_IF_ERROR(check(cameras));
  std::size_t points = 0;
  for (const CameraCloud& camera : cameras) points += camera.cloud.size();
  Cloud merged;
  merged.view = View::of_cameras({});
  for (auto* plane : {&merged.x, &merged.y, &merged.z}) plane->reserve(points);
  if (cameras[0].cloud.has_color()) merged.rgb.reserve(points);
  for (const CameraCloud& camera : cameras) append(camera, merged);
  merged.width = static_cast<std::uint32_t>(points);
  merged.height = 1;
  return merged;
}

absl::StatusOr<std::vector<std::span<const std::uint32_t>>> split_by_camera(const View& view,
                                                                            std::span<const std::uint32_t> values) {
  if (view.cameras.empty()) return absl::InvalidArgumentError("the view has no cameras");
  if (const auto fault = fault_of_cameras(view, values.size())) return absl::InvalidArgumentError(*fault);
  std::vector<std::span<const std::uint32_t>> parts;
  std::size_t begin = 0;
  for (const CameraPoints& camera : view.cameras) {
    parts.push_back(values.subspan(begin, camera.points));
    begin += camera.points;
  }
  return parts;
}

}  // namespace segserve
