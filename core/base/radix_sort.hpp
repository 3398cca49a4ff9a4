// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "core/base/stop_check.hpp"
#include "segserve/stop_token.hpp"

namespace segserve::math {

/// Sorts words by their bits [low, high) with a radix sort; words with equal bits stay in order. `buffer` becomes as
/// large as `words`. The order is unspecified if `check` stopped it.
inline void sort_words(std::vector<std::uint64_t>& words, std::vector<std::uint64_t>& buffer, int low, int high,
                       StopCheck& check) {
  constexpr int kMostBits = 12;
  constexpr std::size_t kBuckets = std::size_t{1} << kMostBits;
  const int passes = (high - low + kMostBits - 1) / kMostBits;
  buffer.resize(words.size());
  for (int pass = 0; pass < passes; ++pass) {
    const int shift = low + (high - low) * pass / passes, end = low + (high - low) * (pass + 1) / passes;
    const std::uint64_t mask = (std::uint64_t{1} << (end - shift)) - 1;
    std::array<std::uint32_t, kBuckets> begin{};
    check.for_each(0, words.size(), [&](std::size_t i) { ++begin[words[i] >> shift & mask]; });
    std::exclusive_scan(begin.begin(), begin.end(), begin.begin(), 0U);
    const bool complete = check.for_each(0, words.size(), [&](std::size_t i) {
      const std::uint64_t word = words[i];
      buffer[begin[word >> shift & mask]++] = word;
    });
    if (!complete) return;
    words.swap(buffer);
  }
}

/// Buffers of a sort, to be kept between calls.
struct SortScratch {
  std::vector<std::uint64_t> words, buffer;
};

/// The number of bits that an index below `count` takes.
inline int index_bits(std::size_t count) { return static_cast<int>(std::bit_width(count)); }

/// Sets `order` to the indices into `keys` that sort the keys in ascending order, equal keys in input order. The order
/// is unspecified if `check` stopped it. Each word to sort holds an index and as many bits of its key as there is room
/// for, so that the sort reads memory from front to back. Mostly all bits fit, or else the sort is repeated for the
/// rest.
inline void sort_order(std::span<const std::uint64_t> keys, std::vector<std::uint32_t>& order, SortScratch& scratch,
                       StopCheck& check) {
  order.resize(keys.size());
  std::iota(order.begin(), order.end(), 0U);
  std::uint64_t varying = 0;
  check.for_each(0, keys.size(), [&](std::size_t i) { varying |= keys[i] ^ keys[0]; });
  const int index = index_bits(keys.size());
  const int room = 64 - index;
  scratch.words.resize(keys.size());
  for (int shift = varying == 0 ? 64 : std::countr_zero(varying), width = std::bit_width(varying); shift < width;
       shift += room) {
    const int bits = std::min(room, width - shift);
    check.for_each(0, keys.size(),
                   [&](std::size_t i) { scratch.words[i] = keys[order[i]] >> shift << index | order[i]; });
    sort_words(scratch.words, scratch.buffer, index, index + bits, check);
    const std::uint64_t mask = (std::uint64_t{1} << index) - 1;
    check.for_each(0, keys.size(),
                   [&](std::size_t i) { order[i] = static_cast<std::uint32_t>(scratch.words[i] & mask); });
    if (check.stopped()) return;
  }
}

/// Does the same with buffers of its own.
inline void sort_order(std::span<const std::uint64_t> keys, std::vector<std::uint32_t>& order, StopCheck& check) {
  SortScratch scratch;
  sort_order(keys, order, scratch, check);
}

/// Does the same without a stop token.
inline void sort_order(std::span<const std::uint64_t> keys, std::vector<std::uint32_t>& order) {
  const StopToken never;
  StopCheck check(never);
  sort_order(keys, order, check);
}

}  // namespace segserve::math
