// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/pose_json.hpp"

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <string>

#include "core/base/status_macros.hpp"
#include "fmt/format.h"

namespace segserve::segctl {
namespace {

using Json = nlohmann::ordered_json;

Json numbers(const Eigen::Ref<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic>>& matrix) {
  Json json = Json::array();
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    for (Eigen::Index column = 0; column < matrix.cols(); ++column) json.push_back(matrix(row, column));
  }
  return json;
}

/// INVALID_ARGUMENT unless the member is a list of so many finite numbers.
absl::Status check_numbers(const Json& json, const char* name, std::size_t count) {
  const auto wrong = [&](const std::string& found) {
    return absl::InvalidArgumentError(fmt::format("\"{}\" must be a list of {} numbers, and {}", name, count, found));
  };
  if (!json.contains(name)) return wrong("is missing");
  const Json& list = json[name];
  if (!list.is_array()) return wrong("is no list");
  if (list.size() != count) return wrong(fmt::format("has {} elements", list.size()));
  for (const Json& value : list) {
    if (!value.is_number() || !std::isfinite(value.get<double>())) return wrong(fmt::format("has {}", value.dump()));
  }
  return absl::OkStatus();
}

}  // namespace

void add_pose(const RigidTransform& pose, Json& json) {
  json["rotation"] = numbers(pose.rotation);
  json["translation"] = numbers(pose.translation);
}

bool has_pose(const Json& json) { return json.contains("rotation") || json.contains("translation"); }

absl::StatusOr<RigidTransform> parse_pose(const Json& json) {
  RETURN_IF_ERROR(check_numbers(json, "rotation", 9));
  RETURN_IF_ERROR(check_numbers(json, "translation", 3));
  RigidTransform pose;
  for (int i = 0; i < 9; ++i) pose.rotation(i / 3, i % 3) = json["rotation"][static_cast<std::size_t>(i)].get<double>();
  for (int i = 0; i < 3; ++i) pose.translation[i] = json["translation"][static_cast<std::size_t>(i)].get<double>();
  return pose;
}

}  // namespace segserve::segctl
