// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/hdr_histogram.hpp"

#include <algorithm>
#include <bit>

namespace segserve::bench {
namespace {

// 2^11 buckets of width 1 are the fewest that tell 2,000 values apart, as 3 digits need. Beyond, each doubling of the
// value has half as many buckets, of twice the width.
constexpr unsigned kHalfBits = 10;
constexpr std::uint64_t kHalf = std::uint64_t{1} << kHalfBits;

/// The number of bits by which the values of a bucket are shifted.
unsigned shift_of(std::size_t index) { return index < 2 * kHalf ? 0 : static_cast<unsigned>(index >> kHalfBits) - 1; }

}  // namespace

std::size_t HdrHistogram::index_of(std::uint64_t value) {
  const auto bits = static_cast<unsigned>(std::bit_width(value));
  const unsigned shift = bits > kHalfBits + 1 ? bits - kHalfBits - 1 : 0;
  return (std::size_t{shift} << kHalfBits) + (value >> shift);
}

std::uint64_t HdrHistogram::lowest_of(std::size_t index) {
  const unsigned shift = shift_of(index);
  return (index - (std::size_t{shift} << kHalfBits)) << shift;
}

std::uint64_t HdrHistogram::highest_of(std::size_t index) {
  return lowest_of(index) + (std::uint64_t{1} << shift_of(index)) - 1;
}

void HdrHistogram::record(std::uint64_t value, std::uint64_t times) {
  if (times == 0) return;
  value = std::min(value, kHighest);
  const std::size_t index = index_of(value);
  if (index >= counts_.size()) counts_.resize(index + 1);
  counts_[index] += times;
  count_ += times;
  max_ = std::max(max_, value);
  sum_ += static_cast<double>(value) * static_cast<double>(times);
}

void HdrHistogram::add(const HdrHistogram& other) {
  counts_.resize(std::max(counts_.size(), other.counts_.size()));
  for (std::size_t i = 0; i < other.counts_.size(); ++i) counts_[i] += other.counts_[i];
  count_ += other.count_;
  max_ = std::max(max_, other.max_);
  sum_ += other.sum_;
}

double HdrHistogram::mean() const { return count_ == 0 ? 0 : sum_ / static_cast<double>(count_); }

std::uint64_t HdrHistogram::value_at_rank(std::uint64_t rank) const {
  std::uint64_t seen = 0;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    seen += counts_[i];
    if (seen >= rank && counts_[i] > 0) return std::min(highest_of(i), max_);
  }
  return max_;
}

}  // namespace segserve::bench
