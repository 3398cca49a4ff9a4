// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "core/base/stop_check.hpp"
#include "segserve/cloud.hpp"

// Which points of a cloud tell where its sensor is.
namespace segserve::codec {

inline bool is_origin(const CloudView& cloud, std::size_t i) {
  return cloud.x[i] == 0 && cloud.y[i] == 0 && cloud.z[i] == 0;
}

inline bool is_point(const CloudView& cloud, std::size_t i) {
  return is_finite(cloud.x[i], cloud.y[i], cloud.z[i]) && !is_origin(cloud, i);
}

/// A number that depends on the position of a point alone, for samples that do not depend on the order of points. It is
/// the finalizer of MurmurHash3 (A. Appleby, 2008).
inline std::uint32_t hash_of(const CloudView& cloud, std::size_t i) {
  std::uint32_t h = std::bit_cast<std::uint32_t>(cloud.x[i]) * 0x9e3779b1U;
  h = (h ^ std::bit_cast<std::uint32_t>(cloud.y[i])) * 0x9e3779b1U;
  h ^= std::bit_cast<std::uint32_t>(cloud.z[i]);
  h = (h ^ (h >> 16U)) * 0x85ebca6bU;
  h = (h ^ (h >> 13U)) * 0xc2b2ae35U;
  return h ^ (h >> 16U);
}

/// Calls function(i) for some points, 16384 or a little more, or for all if there are fewer.
template <typename Function>
void for_each_of_sample(const CloudView& cloud, StopCheck& check, Function function) {
  constexpr std::size_t kSample = 16384;
  const auto every = static_cast<std::uint32_t>(std::max<std::size_t>(1, cloud.size() / kSample));
  check.for_each(0, cloud.size(), [&](std::size_t i) {
    if (hash_of(cloud, i) % every == 0 && is_point(cloud, i)) function(i);
  });
}

}  // namespace segserve::codec
