// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/camera_rig.hpp"

#include <Eigen/Core>
#include <filesystem>
#include <set>
#include <system_error>
#include <utility>

#include "client/segctl/json_list.hpp"
#include "client/segctl/pose_json.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "fmt/format.h"
#include "nlohmann/json.hpp"
#include "segserve/cameras.hpp"
#include "segserve/codec/cloud_file.hpp"

namespace segserve::segctl {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

absl::StatusOr<RigCamera> parse_camera(const Json& json) {
  RETURN_IF_ERROR(check_members(json, {"file", "rotation", "translation"}));
  if (!json.contains("file") || !json["file"].is_string() || json["file"].get<std::string>().empty()) {
    return absl::InvalidArgumentError("it has no \"file\"");
  }
  RigCamera camera{.file = json["file"].get<std::string>(), .pose = {}};
  ASSIGN_OR_RETURN(camera.pose, parse_pose(json));
  if (const auto fault = fault_of_transform(camera.pose)) return absl::InvalidArgumentError("the pose " + *fault);
  return camera;
}

absl::StatusOr<std::vector<RigCamera>> read_cameras(const std::string& path) {
  ASSIGN_OR_RETURN(const Json list, read_json_list(path, "cameras"));
  if (list.size() > kMostCameras) {
    return absl::InvalidArgumentError(
        fmt::format("{}: it has {} cameras, but at most {} are possible", path, list.size(), kMostCameras));
  }
  std::vector<RigCamera> cameras;
  std::set<std::string> names;
  for (const Json& item : list) {
    auto camera = parse_camera(item);
    if (!camera.ok()) return with_prefix(fmt::format("{}: camera {}", path, cameras.size()), camera.status());
    if (!names.insert(fs::path(camera->file).stem().string()).second) {
      return absl::InvalidArgumentError(
          fmt::format("{}: two cameras have files of the name {}", path, fs::path(camera->file).stem().string()));
    }
    cameras.push_back(*std::move(camera));
  }
  return cameras;
}

/// INVALID_ARGUMENT for a pipe, a device or a folder, whose reading could take for ever. Reading tells of a file that
/// is missing.
absl::Status check_is_file(const fs::path& path) {
  std::error_code error;
  const fs::file_type type = fs::status(path, error).type();
  if (type == fs::file_type::regular || type == fs::file_type::not_found) return absl::OkStatus();
  return absl::InvalidArgumentError(fmt::format("{}: it is no regular file", path.string()));
}

/// The pose of the cloud that was read, if `pose` is that of the coordinates of its file in meters.
RigidTransform pose_of_cloud(const RigidTransform& pose, const codec::Placement& placement) {
  const double meters = placement.meters_per_unit();
  const Eigen::Vector3d signs = placement.scale / meters;
  RigidTransform result;
  result.rotation = pose.rotation * signs.asDiagonal();
  result.translation = pose.rotation * (meters * placement.offset) + pose.translation;
  return result;
}

}  // namespace

std::string rig_json(std::span<const RigCamera> cameras) {
  Json list = Json::array();
  for (const RigCamera& camera : cameras) {
    Json json{{"file", camera.file}};
    add_pose(camera.pose, json);
    list.push_back(std::move(json));
  }
  return Json{{"cameras", std::move(list)}}.dump(1) + "\n";
}

absl::StatusOr<RigScene> read_rig(const std::string& path, const codec::ReadOptions& options) {
  ASSIGN_OR_RETURN(const auto rig, read_cameras(path));
  RigScene scene;
  for (const RigCamera& camera : rig) {
    const fs::path file = fs::path(path).parent_path() / camera.file;
    RETURN_IF_ERROR(check_is_file(file));
    ASSIGN_OR_RETURN(scene.of_camera.emplace_back(), codec::load_cloud(file.string(), options));
    scene.files.push_back(file.string());
  }
  std::vector<CameraCloud> clouds;
  for (std::size_t c = 0; c < rig.size(); ++c) {
    const codec::LabeledCloud& content = scene.of_camera[c];
    clouds.push_back({content.cloud, pose_of_cloud(rig[c].pose, content.placement)});
    for (const codec::Warning& warning : content.warnings) {
      scene.merged.warnings.push_back({warning.reason, fmt::format("{}: {}", scene.files[c], warning.message)});
    }
  }
  auto merged = merge_cameras(clouds);
  if (!merged.ok()) return with_prefix(path, merged.status());
  scene.merged.cloud = *std::move(merged);
  scene.merged.view_rule = fmt::format("WORLD with {} cameras, as {} says", rig.size(), path);
  return scene;
}

}  // namespace segserve::segctl
