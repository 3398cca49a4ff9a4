// SPDX-License-Identifier: Apache-2.0
#include "core/voxels/voxel_links.hpp"

#include <algorithm>
#include <utility>

#include "core/base/radix_sort.hpp"

namespace segserve {
namespace {

/// The links in both directions, ascending and distinct.
std::vector<VoxelLink> both_ways(const std::vector<VoxelLink>& links, StopCheck& check) {
  std::vector<std::uint64_t> keys;
  keys.reserve(2 * links.size());
  check.for_each(0, links.size(), [&](std::size_t i) {
    const auto [from, to] = links[i];
    keys.push_back(std::uint64_t{from} << 32U | to);
    keys.push_back(std::uint64_t{to} << 32U | from);
  });
  std::vector<std::uint32_t> order;
  math::sort_order(keys, order, check);
  std::vector<VoxelLink> result;
  result.reserve(keys.size());
  check.for_each(0, keys.size(), [&](std::size_t i) {
    const std::uint64_t key = keys[order[i]];
    const VoxelLink link{static_cast<std::uint32_t>(key >> 32U), static_cast<std::uint32_t>(key)};
    if (result.empty() || link != result.back()) result.push_back(link);
  });
  return result;
}

}  // namespace

void add_links(const std::vector<VoxelLink>& one_way, StopCheck& check, VoxelAdjacency& adjacency) {
  const std::vector<VoxelLink> links = both_ways(one_way, check);
  VoxelAdjacency result;
  result.offset.reserve(adjacency.offset.size());
  result.neighbor.reserve(adjacency.neighbor.size() + links.size());
  result.offset.push_back(0);
  auto link = links.begin();
  check.for_each(0, adjacency.offset.size() - 1, [&](std::size_t i) {
    const auto v = static_cast<std::uint32_t>(i);
    const auto old = adjacency.of(v);
    const auto middle = result.neighbor.insert(result.neighbor.end(), old.begin(), old.end()) - result.neighbor.begin();
    const auto grown = static_cast<std::ptrdiff_t>(result.neighbor.size());
    for (; link != links.end() && link->from == v; ++link) result.neighbor.push_back(link->to);
    const auto begin = result.neighbor.begin();
    std::inplace_merge(begin + middle, begin + grown, result.neighbor.end());
    result.offset.push_back(static_cast<std::uint32_t>(result.neighbor.size()));
    return result.offset[i + 1] - result.offset[i] + std::uint64_t{1};
  });
  adjacency = std::move(result);
}

}  // namespace segserve
