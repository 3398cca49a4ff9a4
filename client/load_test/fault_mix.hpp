// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string_view>

#include "absl/status/statusor.h"

namespace segserve::bench {

/// The faults of clients in the field, which a load test makes beside the frames that it measures.
struct FaultMix {
  std::size_t slow_readers = 0;  ///< streams that send what they may and read one message in two seconds
  // The number of other frames of each kind for each frame that is measured, 0 to 1.
  double vanish = 0;     ///< whose client is gone when half of the payload is sent
  double malformed = 0;  ///< whose payload is no cloud
  double cancel = 0;     ///< that the client cancels as soon as they are sent

  bool any() const { return slow_readers > 0 || vanish > 0 || malformed > 0 || cancel > 0; }
};

/// "slow-reader=2,vanish=1%,malformed=1%,cancel=1%", in any order; what is left out is 0. INVALID_ARGUMENT that names
/// all that is wrong.
absl::StatusOr<FaultMix> parse_fault_mix(std::string_view text);

}  // namespace segserve::bench
