// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "test/core/support/clouds.hpp"

namespace segserve::test {

/// A street around a spinning LiDAR: the ground 1.8 m below it, a wall at y = 12, boxes, and nothing else.
struct Street {
  struct Box {
    float low[3], high[3];
  };

  int rings = 40;
  double ring = 0.4, azimuth = 0.25;  ///< degrees between rings, and between points of a ring
  double from = 0, to = 360;          ///< degrees of azimuth that are swept
  double motion = 0;            ///< meters along x by which the sensor moves during a turn; points are where they are
  float sensor[3] = {0, 0, 0};  ///< in the cloud's frame, meters
  std::vector<Box> boxes = {{{8, 2, -1.8F}, {12, 4, -0.3F}}};

  /// The surface of each point: 0 the ground, 1 the wall, 2 and up the boxes. Points without an echo are left out.
  std::vector<std::uint32_t> surface = {};

  Cloud sweep() {
    Cloud cloud = unorganized(View::world(sensor[0], sensor[1], sensor[2]));
    surface.clear();
    const auto columns = static_cast<int>((to - from) / azimuth);
    for (int i = 0; i < rings; ++i) {
      for (int k = 0; k < columns; ++k) {
        constexpr double kDegree = 3.14159265358979323846 / 180;
        const double a = (from + azimuth * k) * kDegree, e = (3 - ring * i) * kDegree;
        cast(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e), motion * k / columns, cloud);
      }
    }
    return cloud;
  }

 private:
  void cast(double x, double y, double z, double shift, Cloud& cloud) {
    constexpr double kFar = 60;
    double range = kFar;
    std::uint32_t hit = 0;
    const auto meet = [&](double distance, std::uint32_t what) {
      if (distance > 0 && distance < range) range = distance, hit = what;
    };
    meet(-1.8 / z, 0);
    meet(12 / y, 1);
    for (std::size_t b = 0; b < boxes.size(); ++b) {
      meet(distance_to(boxes[b], shift, x, y, z), static_cast<std::uint32_t>(2 + b));
    }
    if (range >= kFar) return;
    add(cloud, static_cast<float>(range * x + shift) + sensor[0], static_cast<float>(range * y) + sensor[1],
        static_cast<float>(range * z) + sensor[2], 0);
    surface.push_back(hit);
  }

  static double distance_to(const Box& box, double shift, double x, double y, double z) {
    double first = 0, last = std::numeric_limits<double>::infinity();
    const double ray[3] = {x, y, z};
    for (int axis = 0; axis < 3; ++axis) {
      const double from_here = axis == 0 ? shift : 0;
      const double a = (box.low[axis] - from_here) / ray[axis], b = (box.high[axis] - from_here) / ray[axis];
      first = std::max(first, std::min(a, b)), last = std::min(last, std::max(a, b));
    }
    return first < last ? first : -1;
  }
};

}  // namespace segserve::test
