// SPDX-License-Identifier: Apache-2.0
#include "segserve/stop_token.hpp"

namespace segserve {

absl::Status StopToken::check() const {
  if (cancelled_ != nullptr && cancelled_->load(std::memory_order_relaxed)) {
    return absl::CancelledError("the segmentation was cancelled");
  }
  if (deadline_ && Clock::now() >= *deadline_) {
    return absl::DeadlineExceededError("the deadline passed during the segmentation");
  }
  return absl::OkStatus();
}

bool StopToken::stopped() const {
  return (cancelled_ != nullptr && cancelled_->load(std::memory_order_relaxed)) ||
         (deadline_ && Clock::now() >= *deadline_);
}

}  // namespace segserve
