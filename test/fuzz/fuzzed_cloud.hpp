// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstdlib>

#include "absl/status/statusor.h"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/codec/labeled_cloud.hpp"

namespace segserve::codec {

/// Limits that small inputs can exceed.
inline constexpr DecodeLimits kFuzzLimits{.max_points = 100'000, .max_bytes = 8'000'000};

/// Ends the program unless a reader refused its bytes with a message, or made a cloud within the limits.
inline void expect_sound(const absl::StatusOr<LabeledCloud>& decoded) {
  if (!decoded.ok()) {
    if (!absl::IsInvalidArgument(decoded.status()) || decoded.status().message().empty()) std::abort();
    return;
  }
  const Cloud& cloud = decoded->cloud;
  const std::size_t points = cloud.x.size();
  const bool planes_fit = cloud.y.size() == points && cloud.z.size() == points &&
                          (cloud.rgb.empty() || cloud.rgb.size() == points) &&
                          (decoded->label.empty() || decoded->label.size() == points);
  if (!planes_fit || points > kFuzzLimits.max_points || std::uint64_t{cloud.width} * cloud.height != points) {
    std::abort();
  }
  for (const Warning& warning : decoded->warnings) {
    if (warning.message.empty()) std::abort();
  }
}

}  // namespace segserve::codec
