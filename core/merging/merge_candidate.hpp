// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>

namespace segserve {

/// The first key by which edges merge: those whose weight is below the threshold come first, then those of regions that
/// are too small, then the others.
enum class MergePriority : std::uint8_t { kBelowThreshold, kTooSmall, kOther, kNoEdge };

/// An edge of the region graph, in the order in which edges merge: by priority, then by dissimilarity (not NaN), then
/// by the numbers of its regions (below 2^31), the smaller one first. It is a single number, whose comparison has no
/// branches: those of a tournament tree would often be mispredicted.
class MergeCandidate {
 public:
  /// Comes after all edges.
  MergeCandidate() : MergeCandidate(MergePriority::kNoEdge, 0, 0, 0) {}
  MergeCandidate(MergePriority priority, double dissimilarity, std::uint32_t a, std::uint32_t b)
      : key_(Key{static_cast<std::uint8_t>(priority)} << (64 + 2 * kIdBits) |
             Key{to_ascending(dissimilarity)} << (2 * kIdBits) | Key{a} << kIdBits | b) {}

  bool is_edge() const { return priority() != MergePriority::kNoEdge; }
  MergePriority priority() const { return static_cast<MergePriority>(key_ >> (64 + 2 * kIdBits)); }
  double dissimilarity() const { return from_ascending(static_cast<std::uint64_t>(key_ >> (2 * kIdBits))); }
  std::uint32_t a() const { return static_cast<std::uint32_t>(key_ >> kIdBits) & kIdMask; }
  std::uint32_t b() const { return static_cast<std::uint32_t>(key_) & kIdMask; }
  bool operator==(const MergeCandidate& o) const { return key_ == o.key_; }
  bool operator<(const MergeCandidate& o) const { return key_ < o.key_; }

 private:
  __extension__ using Key = unsigned __int128;
  static constexpr int kIdBits = 31;
  static constexpr std::uint32_t kIdMask = (std::uint32_t{1} << kIdBits) - 1;
  static constexpr std::uint64_t kSign = std::uint64_t{1} << 63;

  /// An integer for each double, in their order; -0 counts as 0.
  static std::uint64_t to_ascending(double d) {
    const auto bits = std::bit_cast<std::uint64_t>(d + 0.0);
    return (bits & kSign) != 0 ? ~bits : bits | kSign;
  }
  static double from_ascending(std::uint64_t n) { return std::bit_cast<double>((n & kSign) != 0 ? n ^ kSign : ~n); }

  Key key_;
};

}  // namespace segserve
