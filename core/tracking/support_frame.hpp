// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "core/math/vec3.hpp"
#include "core/tracking/rigid_motion.hpp"
#include "core/tracking/scene_tree.hpp"
#include "segserve/cloud.hpp"
#include "segserve/segment.hpp"
#include "segserve/tracking.hpp"

namespace segserve::tracking {

/// The plane that supports the objects: normal . p = offset. The normal points to the sensor, without one up (+z).
struct Plane {
  Vec3 normal;
  double offset = 0;
};

/// The plane of the frame: the one that was removed from the cloud, or else that of a large flat segment: the one most
/// like `before`, without it the largest. nullopt if no segment is large and flat.
std::optional<Plane> find_plane(const SceneTree& scene, const Segmentation& segmentation, const View& view,
                                const std::optional<Plane>& before);

/// A frame in which x and y span the plane and z is the height above it, as the motion from it to the cloud. Its x axis
/// is that of the cloud, as far as the plane allows. Without a plane z is up: -y in a CAMERA view, else z.
RigidMotion support_frame(const std::optional<Plane>& plane, const View& view);

}  // namespace segserve::tracking
