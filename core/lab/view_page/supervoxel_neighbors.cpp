// SPDX-License-Identifier: Apache-2.0
#include "core/lab/view_page/supervoxel_neighbors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "absl/container/flat_hash_map.h"

namespace segserve::view_page {
namespace {

// A voxel has few supervoxels unless it is far too large for the cloud. Then some neighbors are not found, instead of
// very many.
constexpr std::size_t kMostInVoxel = 64;

constexpr std::int64_t kHalf = std::int64_t{1} << 20U;  // Coordinates of voxels have 21 bits in a key.

/// A voxel as one number. Neighbors differ by a sum of `kSteps`.
std::uint64_t key_of(const std::array<double, 3>& voxel) {
  std::uint64_t key = 0;
  for (const double v : voxel) {
    const auto index = static_cast<std::int64_t>(std::floor(std::clamp(v, -0x1p19, 0x1p19))) + kHalf;
    key = key << 21U | static_cast<std::uint64_t>(index);
  }
  return key;
}

/// The 13 voxels of the 26 around one that have greater keys, as differences of keys.
std::array<std::uint64_t, 13> forward_steps() {
  std::array<std::uint64_t, 13> steps{};
  std::size_t count = 0;
  for (std::int64_t x = -1; x <= 1; ++x) {
    for (std::int64_t y = -1; y <= 1; ++y) {
      for (std::int64_t z = -1; z <= 1; ++z) {
        const std::int64_t step = (x << 42U) + (y << 21U) + z;
        if (step > 0) steps[count++] = static_cast<std::uint64_t>(step);
      }
    }
  }
  return steps;
}

using Member = std::pair<std::uint64_t, std::uint32_t>;  // Voxel and supervoxel.

std::vector<Member> members_of(const CloudView& cloud, std::span<const std::uint32_t> supervoxels, double voxel) {
  std::vector<Member> members;
  members.reserve(supervoxels.size());
  const bool is_camera = cloud.view.kind == ViewKind::kCamera;
  for (std::size_t i = 0; i < supervoxels.size(); ++i) {
    if (supervoxels[i] == 0) continue;
    std::array<double, 3> p{cloud.x[i], cloud.y[i], cloud.z[i]};
    if (is_camera) p = {p[0] / p[2], p[1] / p[2], std::log(p[2])};
    if (!std::ranges::all_of(p, [](double v) { return std::isfinite(v); })) continue;
    for (double& v : p) v /= voxel;
    members.emplace_back(key_of(p), supervoxels[i] - 1);
  }
  std::ranges::sort(members);
  return members;
}

/// The median number of points in a voxel. The members are sorted.
double points_per_voxel(const std::vector<Member>& members) {
  std::vector<std::size_t> counts;
  for (std::size_t i = 0; i < members.size(); ++i) {
    if (i == 0 || members[i].first != members[i - 1].first) counts.push_back(0);
    ++counts.back();
  }
  if (counts.empty()) return 1;
  const auto middle = counts.begin() + static_cast<std::ptrdiff_t>(counts.size() / 2);
  std::ranges::nth_element(counts, middle);
  return static_cast<double>(*middle);
}

/// Adds the pairs of different supervoxels in two voxels, which are ranges of the members.
void add_pairs(std::span<const Member> a, std::span<const Member> b,
               std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs) {
  for (const Member& one : a) {
    for (const Member& other : b) {
      if (one.second != other.second) pairs.emplace_back(std::minmax(one.second, other.second));
    }
  }
}

}  // namespace

SupervoxelNeighbors supervoxel_neighbors(const CloudView& cloud, std::span<const std::uint32_t> supervoxels,
                                         double voxel) {
  std::vector<Member> members = members_of(cloud, supervoxels, voxel);
  SupervoxelNeighbors result;
  result.spacing = voxel / std::sqrt(points_per_voxel(members));
  members.erase(std::unique(members.begin(), members.end()), members.end());

  absl::flat_hash_map<std::uint64_t, std::span<const Member>> voxels;
  for (std::size_t begin = 0, end = 0; begin < members.size(); begin = end) {
    while (end < members.size() && members[end].first == members[begin].first) ++end;
    voxels[members[begin].first] = std::span<const Member>(members).subspan(begin, std::min(end - begin, kMostInVoxel));
  }
  const auto steps = forward_steps();
  for (const auto& [key, inside] : voxels) {
    add_pairs(inside, inside, result.pairs);
    for (const std::uint64_t step : steps) {
      if (const auto other = voxels.find(key + step); other != voxels.end()) {
        add_pairs(inside, other->second, result.pairs);
      }
    }
  }
  std::ranges::sort(result.pairs);
  result.pairs.erase(std::unique(result.pairs.begin(), result.pairs.end()), result.pairs.end());
  return result;
}

}  // namespace segserve::view_page
