// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

// Values tell whether columns without names are colors.
namespace segserve::codec {

/// Tells by the values of a column whether they are colors, each packed in one number.
class PackedColorEvidence {
 public:
  void take(double value) {
    constexpr double kTiny = 1e-37, kHuge = 1e37;  // The bits of a color, as a float, have one of these magnitudes.
    constexpr double kLargest = std::numeric_limits<std::uint32_t>::max();
    const double magnitude = std::abs(value);
    are_bits_ = are_bits_ && !(magnitude >= kTiny && magnitude <= kHuge);
    are_integers_ = are_integers_ && value >= 0 && value <= kLargest && value == std::floor(value);
    descends_ = descends_ || value < last_;
    last_ = value;
    if (std::isfinite(value)) smallest_ = std::min(smallest_, value), largest_ = std::max(largest_, value);
  }

  /// Times ascend, and intensities have 16 bits at most.
  bool are_colors() const {
    constexpr double kMostIntensity = 65535;
    const bool are_integers = are_integers_ && largest_ > kMostIntensity && (descends_ || smallest_ == largest_);
    return are_integers || (are_bits_ && (smallest_ < 0 || largest_ > 0));
  }

 private:
  double last_ = -std::numeric_limits<double>::infinity();
  double smallest_ = std::numeric_limits<double>::infinity(), largest_ = -std::numeric_limits<double>::infinity();
  bool are_bits_ = true, are_integers_ = true, descends_ = false;
};

/// Tells by the values of a column whether it is a channel of a color. A color that is missing has NaN or -1.
class ChannelEvidence {
 public:
  void take(double value) {
    rises_ = rises_ && value > last_;
    last_ = value;
    if (std::isnan(value) || value == -1) return;
    ++count_;
    smallest_ = std::min(smallest_, value), largest_ = std::max(largest_, value);
    is_whole_ = is_whole_ && value == std::floor(value);
  }

  double largest() const { return largest_; }
  bool is_in_range() const { return count_ > 0 && smallest_ >= 0 && largest_ <= 65535; }
  bool has_decimals() const { return !is_whole_; }
  bool is_constant() const { return smallest_ == largest_; }
  /// Whether the channel has whole numbers of which some are neither 0 nor 1, nor all the same.
  bool has_levels() const { return is_whole_ && largest_ > 1 && smallest_ < largest_; }
  bool rises_with_rows(std::size_t points) const {
    constexpr std::size_t kFewest = 100;
    return points >= kFewest && rises_;
  }

 private:
  double last_ = -std::numeric_limits<double>::infinity();
  double smallest_ = std::numeric_limits<double>::infinity(), largest_ = -std::numeric_limits<double>::infinity();
  std::size_t count_ = 0;
  bool is_whole_ = true, rises_ = true;
};

/// Whether three columns are alike, as the channels of a color are: none has levels where another one has decimals, nor
/// are two always the same whole number beside one that varies, nor is any whole where decimals exceed 1; the largest
/// values are of one magnitude, unless they are 0, and they are not as small as classes, returns or flags are. The last
/// columns may be full colors, of 0 and 1.
bool are_channels(const std::array<ChannelEvidence, 3>& channels, bool are_last);

}  // namespace segserve::codec
