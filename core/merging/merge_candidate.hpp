#pragma once

#include <bit>
#include <cstdint>

namespace segserve {

/// When an edge's turn to merge comes: below the threshold first; then what is too small; then the rest.
enum class MergeTurn : std::uint8_t { kFirst, kTooSmall, kLast, kNever };

/// An edge of the region graph in the order of merging: by turn, dissimilarity (no NaN) and the ids of its regions
/// (below 2^31), the smaller ones first. All in one number, whose comparison takes no branch: a tournament's would be
/// mispredicted.
class MergeCandidate {
 public:
  /// Behind all edges.
  MergeCandidate() : MergeCandidate(MergeTurn::kNever, 0, 0, 0) {}
  MergeCandidate(MergeTurn turn, double dissimilarity, std::uint32_t a, std::uint32_t b)
      : key_(Key{static_cast<std::uint8_t>(turn)} << (64 + 2 * kIdBits) |
             Key{ascending(dissimilarity)} << (2 * kIdBits) | Key{a} << kIdBits | b) {}

  MergeTurn turn() const { return static_cast<MergeTurn>(key_ >> (64 + 2 * kIdBits)); }
  double dissimilarity() const { return of_ascending(static_cast<std::uint64_t>(key_ >> (2 * kIdBits))); }
  std::uint32_t a() const { return static_cast<std::uint32_t>(key_ >> kIdBits) & kIdMask; }
  std::uint32_t b() const { return static_cast<std::uint32_t>(key_) & kIdMask; }
  bool operator==(const MergeCandidate& o) const { return key_ == o.key_; }
  bool operator<(const MergeCandidate& o) const { return key_ < o.key_; }

 private:
  __extension__ using Key = unsigned __int128;
  static constexpr int kIdBits = 31;
  static constexpr std::uint32_t kIdMask = (std::uint32_t{1} << kIdBits) - 1;
  static constexpr std::uint64_t kSign = std::uint64_t{1} << 63;

  /// Integers in the order of the doubles, and back; -0 counts as 0.
  static std::uint64_t ascending(double d) {
    const auto bits = std::bit_cast<std::uint64_t>(d + 0.0);
    return (bits & kSign) != 0 ? ~bits : bits | kSign;
  }
  static double of_ascending(std::uint64_t n) { return std::bit_cast<double>((n & kSign) != 0 ? n ^ kSign : ~n); }

  Key key_;
};

}  // namespace segserve
