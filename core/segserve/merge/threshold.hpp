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
    double low = -kFarthest, high = kFarthest;
    if (!(weight(low) < threshold)) high = low;
    if (weight(high) < threshold) low = high;
    while (high - low > kMargin / 2) {
      const double middle = low + (high - low) / 2;
      (weight(middle) < threshold ? low : high) = middle;
    }
    surely_below_ = low - kMargin;
    surely_not_ = high + kMargin;
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
