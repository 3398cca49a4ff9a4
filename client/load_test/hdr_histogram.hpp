// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace segserve::bench {

/// Counts of integer values in buckets whose width grows with the value, as HdrHistogram has them for 3 significant
/// digits (Gil Tene, http://hdrhistogram.org): values below 2048 have a bucket each, and every larger bucket is at most
/// 1/1024 of its values wide. So a percentile is right within 0.1 %, and no more than 30,000 numbers are kept, whatever
/// the number of values is. Their unit is the caller's; the load test records microseconds.
class HdrHistogram {
 public:
  static constexpr int kSignificantDigits = 3;
  /// The largest value that is told from larger ones: a day in microseconds.
  static constexpr std::uint64_t kHighest = 86'400'000'000;

  /// The index of the bucket that counts a value, and the smallest and the largest value of a bucket.
  static std::size_t index_of(std::uint64_t value);
  static std::uint64_t lowest_of(std::size_t index);
  static std::uint64_t highest_of(std::size_t index);

  /// Counts a value so many times. A value beyond kHighest counts as kHighest.
  void record(std::uint64_t value, std::uint64_t times = 1);
  void add(const HdrHistogram& other);

  std::uint64_t count() const { return count_; }
  std::uint64_t max() const { return max_; }  ///< exact; 0 without values
  double mean() const;                        ///< exact; 0 without values
  /// The value of this rank, from 1 to count(): the largest one that its bucket counts, but no more than max().
  std::uint64_t value_at_rank(std::uint64_t rank) const;

  /// The counts by index, up to the last one that is not 0.
  const std::vector<std::uint64_t>& counts() const { return counts_; }

 private:
  std::vector<std::uint64_t> counts_;
  std::uint64_t count_ = 0;
  std::uint64_t max_ = 0;
  double sum_ = 0;
};

}  // namespace segserve::bench
