// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <vector>

namespace segserve {

/// A tournament tree: the smallest of n values, of which single ones change. A change takes O(log n) at most, because
/// it ends where the winner stays the same.
///
///     TournamentTree<int> tree(3, 100);  // three values of 100
///     tree.set(1, 7);
///     tree.winner();  // 7
template <typename Value>
class TournamentTree {
 public:
  /// All values are `largest`, which no value may exceed.
  TournamentTree(std::size_t n, Value largest)
      : leaves_(std::bit_ceil(std::max<std::size_t>(n, 1))), nodes_(2 * leaves_, largest) {}

  const Value& winner() const { return nodes_[1]; }
  const Value& operator[](std::size_t i) const { return nodes_[leaves_ + i]; }

  void set(std::size_t i, const Value& value) {
    std::size_t node = leaves_ + i;
    nodes_[node] = value;
    for (node /= 2; node >= 1; node /= 2) {
      const Value& left = nodes_[2 * node];
      const Value& right = nodes_[2 * node + 1];
      const Value& winner = right < left ? right : left;
      if (winner == nodes_[node]) return;
      nodes_[node] = winner;
    }
  }

 private:
  std::size_t leaves_;
  std::vector<Value> nodes_;
};

}  // namespace segserve
