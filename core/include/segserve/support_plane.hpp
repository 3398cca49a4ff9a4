#pragma once

#include <cstddef>

#include "core/math/vec3.hpp"

namespace segserve {

/// The plane n p = offset, in the frame of the cloud, metres.
struct SupportPlane {
  Vec3 normal;             ///< unit, towards the objects: to the camera, in a WORLD view up (+z); 0 if none was found
  double offset = 0;       ///< metres
  std::size_t points = 0;  ///< that belong to it; 0 if none was found
  bool operator==(const SupportPlane&) const = default;
};

}  // namespace segserve
