// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <string>

#include "proto/wire/cloud_message.hpp"
#include "proto/wire/request_message.hpp"
#include "segserve/cloud.hpp"
#include "segserve/v1/segmentation_service.pb.h"

namespace segserve::server {

/// A gray wall 1.2 m from the camera with a red box before it; the last column was not measured.
inline Cloud wall_with_box(std::uint32_t width = 160, std::uint32_t height = 120) {
  Cloud cloud;
  cloud.width = width;
  cloud.height = height;
  cloud.view = View::camera();
  const auto focal = static_cast<float>(width);
  for (std::uint32_t row = 0; row < height; ++row) {
    for (std::uint32_t column = 0; column < width; ++column) {
      const bool box = column > width / 3 && column < width / 2 && row > height / 3 && row < height / 2;
      const float depth = column + 1 == width ? std::numeric_limits<float>::quiet_NaN() : box ? 0.9F : 1.2F;
      cloud.x.push_back((static_cast<float>(column) - static_cast<float>(width) / 2) / focal * depth);
      cloud.y.push_back((static_cast<float>(row) - static_cast<float>(height) / 2) / focal * depth);
      cloud.z.push_back(depth);
      cloud.rgb.push_back(box ? pack_rgb(200, 30, 30) : pack_rgb(120, 120, 120));
    }
  }
  return cloud;
}

/// An unorganized cloud of equal points.
inline Cloud equal_points(std::uint32_t count, float x, float y, float z, View view = View::camera()) {
  Cloud cloud;
  cloud.x.assign(count, x);
  cloud.y.assign(count, y);
  cloud.z.assign(count, z);
  cloud.rgb.assign(count, pack_rgb(1, 2, 3));
  cloud.width = count;
  cloud.height = 1;
  cloud.view = view;
  return cloud;
}

inline v1::SegmentRequest request_for(const CloudView& cloud, v1::Compression compression = v1::COMPRESSION_NONE) {
  v1::SegmentRequest request;
  *request.mutable_cloud() = wire::to_planar_message(cloud, compression).value();
  return request;
}

inline v1::SegmentRequest request_for_pcd(std::string file) {
  v1::SegmentRequest request;
  *request.mutable_cloud() = wire::to_pcd_message(std::move(file), std::nullopt);
  return request;
}

}  // namespace segserve::server
