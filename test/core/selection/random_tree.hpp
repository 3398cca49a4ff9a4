// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "segserve/merge_tree.hpp"

namespace segserve {

/// A tree whose merges are random, with some equal weights and up to two JOINED rows.
inline MergeTree random_tree(std::uint32_t leaves, std::mt19937& random) {
  const auto below = [&](std::size_t n) { return static_cast<std::uint32_t>(random() % n); };
  TreeColumns columns;
  std::vector<std::uint32_t> alive;
  for (std::uint32_t leaf = 0; leaf < leaves; ++leaf) {
    columns.leaf_points.push_back(1 + below(20));
    alive.push_back(leaf);
  }
  const std::uint32_t rows = leaves - 1;
  columns.merged_rows = rows - below(std::min(rows, 2U) + 1);
  const auto take = [&] {
    std::swap(alive[below(alive.size())], alive.back());
    const std::uint32_t node = alive.back();
    alive.pop_back();
    return node;
  };
  for (std::uint32_t row = 0; row < rows; ++row) {
    const auto [left, right] = std::minmax({take(), take()});
    columns.left.push_back(left);
    columns.right.push_back(right);
    columns.weight.push_back(row < columns.merged_rows ? below(11) / 10.0 : 1.0);
    alive.push_back(leaves + row);
  }
  return *complete(std::move(columns));
}

}  // namespace segserve
