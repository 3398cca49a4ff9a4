// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

// Classes with the fields that messages of ROS have.
namespace segserve::ros::fake {

struct Time1 {
  std::uint32_t sec = 0, nsec = 0;
};
struct Time2 {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
};

template <typename Time>
struct Header {
  Time stamp;
  std::string frame_id;
};

struct PointField {
  std::string name;
  std::uint32_t offset = 0;
  std::uint8_t datatype = 0;
  std::uint32_t count = 0;
};

template <typename Time>
struct PointCloud2 {
  Header<Time> header;
  std::uint32_t height = 0, width = 0;
  std::vector<PointField> fields;
  std::uint8_t is_bigendian = 0;
  std::uint32_t point_step = 0, row_step = 0;
  std::vector<std::uint8_t> data;
  std::uint8_t is_dense = 0;
};

template <typename Time>
struct Marker {
  enum : std::int32_t { ADD = 0, DELETEALL = 3, CUBE = 1, TEXT_VIEW_FACING = 9 };
  struct Point {
    double x = 0, y = 0, z = 0;
  };
  struct Quaternion {
    double x = 0, y = 0, z = 0, w = 0;
  };
  struct Color {
    float r = 0, g = 0, b = 0, a = 0;
  };
  struct Pose {
    Point position;
    Quaternion orientation;
  };
  Header<Time> header;
  std::string ns;
  std::int32_t id = 0, type = 0, action = 0;
  Pose pose;
  Point scale;
  Color color;
  std::string text;
};

template <typename Time>
struct MarkerArray {
  std::vector<Marker<Time>> markers;
};

}  // namespace segserve::ros::fake
