// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sensor_msgs/PointCloud2.h>
#include <visualization_msgs/MarkerArray.h>

#include <memory>

// The messages of ROS 1 under C++20. Their classes ask their allocator for the member `rebind`, which std::allocator
// has lost with that version. So they get an allocator that has it and is otherwise the same. It changes no byte that
// is sent.
namespace segserve::ros {

template <typename T>
struct RebindingAllocator : std::allocator<T> {
  // NOLINTBEGIN(readability-identifier-naming): the names that allocators have
  template <typename U>
  struct rebind {
    using other = RebindingAllocator<U>;
  };
  // NOLINTEND(readability-identifier-naming)
  RebindingAllocator() = default;
  template <typename U>
  RebindingAllocator(const RebindingAllocator<U>& /*other*/) {}  // NOLINT(google-explicit-constructor): an allocator's
};

using PointCloud2 = sensor_msgs::PointCloud2_<RebindingAllocator<void>>;
using MarkerArray = visualization_msgs::MarkerArray_<RebindingAllocator<void>>;

}  // namespace segserve::ros
