// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

namespace segserve::client {

/// Bounds how many frames are sent to a second server because they are late: one for every ten frames, and what was not
/// used is kept for up to ten.
class HedgeBudget {
 public:
  /// A frame was sent for the first time.
  void on_frame() { tenths_ = std::min(tenths_ + 1, kMost); }
  bool has_one() const { return tenths_ >= kOne; }
  /// has_one() must be true.
  void take_one() { tenths_ -= kOne; }

 private:
  static constexpr int kOne = 10, kMost = 100;
  int tenths_ = kOne;
};

}  // namespace segserve::client
