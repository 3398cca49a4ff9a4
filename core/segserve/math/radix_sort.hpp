#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

namespace segserve::math {

/// The order (indices into `keys`) that sorts the keys ascending, equal keys in input order: a
/// radix sort of 11 bits a pass that leaves out passes in which all keys agree.
inline void sort_order(std::span<const std::uint64_t> keys, std::vector<std::uint32_t>& order) {
  constexpr int kBits = 11;
  constexpr std::size_t kBuckets = std::size_t{1} << kBits;
  order.resize(keys.size());
  std::iota(order.begin(), order.end(), 0U);
  if (keys.empty()) return;
  std::uint64_t varying = 0;
  for (const std::uint64_t key : keys) varying |= key ^ keys[0];
  std::vector<std::uint32_t> previous(keys.size());
  for (int shift = 0; shift < 64; shift += kBits) {
    if (((varying >> shift) & (kBuckets - 1)) == 0) continue;
    std::array<std::uint32_t, kBuckets> begin{};
    for (const std::uint64_t key : keys) ++begin[(key >> shift) & (kBuckets - 1)];
    std::exclusive_scan(begin.begin(), begin.end(), begin.begin(), 0U);
    previous.swap(order);
    for (const std::uint32_t index : previous) order[begin[(keys[index] >> shift) & (kBuckets - 1)]++] = index;
  }
}

}  // namespace segserve::math
