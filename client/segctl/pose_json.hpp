// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "nlohmann/json.hpp"
#include "segserve/rigid_transform.hpp"

namespace segserve::segctl {

/// Adds a pose to an object: the nine numbers of "rotation", row by row, and the three of "translation", meters.
void add_pose(const RigidTransform& pose, nlohmann::ordered_json& json);

/// Whether an object has a part of a pose.
bool has_pose(const nlohmann::ordered_json& json);

/// The pose of an object. INVALID_ARGUMENT unless it has nine and three finite numbers.
absl::StatusOr<RigidTransform> parse_pose(const nlohmann::ordered_json& json);

}  // namespace segserve::segctl
