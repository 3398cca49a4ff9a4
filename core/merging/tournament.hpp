#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <vector>

namespace segserve {

/// The minimum of n values of which single ones change: a complete binary tree of winners, at most O(log n) a
/// change: it ends where the winner stays the same. `worst` is a value that loses against all others.
template <typename Value>
class Tournament {
 public:
  Tournament(std::size_t n, Value worst)
      : leaves_(std::bit_ceil(std::max<std::size_t>(n, 1))), nodes_(2 * leaves_, worst) {}

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
