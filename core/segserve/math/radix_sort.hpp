#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "segserve/pipeline/stop_token.hpp"

namespace segserve::math {

/// The order (indices into `keys`) that sorts the keys ascending, equal keys in input order: a
/// radix sort of 11 bits a pass that leaves out passes in which all keys agree. If `check` stops it the order is
/// useless. `previous` is a buffer.
inline void sort_order(std::span<const std::uint64_t> keys, std::vector<std::uint32_t>& order,
                       std::vector<std::uint32_t>& previous, StopCheck& check) {
  constexpr int kBits = 11;
  constexpr std::size_t kBuckets = std::size_t{1} << kBits;
  order.resize(keys.size());
  std::iota(order.begin(), order.end(), 0U);
  if (keys.empty()) return;
  std::uint64_t varying = 0;
  check.for_each(0, keys.size(), [&](std::size_t i) { varying |= keys[i] ^ keys[0]; });
  previous.resize(keys.size());
  for (int shift = 0; shift < 64; shift += kBits) {
    if (((varying >> shift) & (kBuckets - 1)) == 0) continue;
    std::array<std::uint32_t, kBuckets> begin{};
    check.for_each(0, keys.size(), [&](std::size_t i) { ++begin[(keys[i] >> shift) & (kBuckets - 1)]; });
    std::exclusive_scan(begin.begin(), begin.end(), begin.begin(), 0U);
    previous.swap(order);
    const bool complete = check.for_each(0, keys.size(), [&](std::size_t i) {
      order[begin[(keys[previous[i]] >> shift) & (kBuckets - 1)]++] = previous[i];
    });
    if (!complete) return;
  }
}

inline void sort_order(std::span<const std::uint64_t> keys, std::vector<std::uint32_t>& order, StopCheck& check) {
  std::vector<std::uint32_t> previous;
  sort_order(keys, order, previous, check);
}

inline void sort_order(std::span<const std::uint64_t> keys, std::vector<std::uint32_t>& order) {
  const StopToken never;
  StopCheck check(never);
  sort_order(keys, order, check);
}

}  // namespace segserve::math
