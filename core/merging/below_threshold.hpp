#pragma once

#include <limits>

namespace segserve {

/// Whether a weight is below a threshold, told from its dissimilarity. A weight costs an exponential, and merging asks
/// for each edge that changes: only next to the threshold is there any need for it.
class BelowThreshold {
 public:
  /// `weight(dissimilarity)` grows with it, up to rounding.
  template <typename Weight>
  BelowThreshold(Weight&& weight, double threshold) : threshold_(threshold) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    double low = -kFarthest, high = kFarthest;
    const bool never = !(weight(low) < threshold), always = weight(high) < threshold;
    while (!never && !always && high - low > kMargin / 2) {
      const double middle = low + (high - low) / 2;
      (weight(middle) < threshold ? low : high) = middle;
    }
    surely_below_ = never ? -kInfinity : (always ? high : low) - kMargin;
    surely_not_ = always ? kInfinity : (never ? low : high) + kMargin;
  }

  template <typename Weight>
  bool operator()(Weight&& weight, double dissimilarity) const {
    if (dissimilarity < surely_below_) return true;
    if (dissimilarity > surely_not_) return false;
    return weight(dissimilarity) < threshold_;
  }

 private:
  static constexpr double kFarthest = 1000;  // there weights are saturated
  static constexpr double kMargin = 1e-9;    // rounding errors of a weight are those of a far smaller step

  double threshold_, surely_below_, surely_not_;
};

}  // namespace segserve
