// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/stop_token.hpp"

// Coordinates on a grid: QUANTISED.md describes the format byte by byte.
namespace segserve::codec {

/// Error bounds that the format knows, meters: 0.1 to 10 mm.
inline constexpr double kMinErrorBound = 0.0001;
inline constexpr double kMaxErrorBound = 0.01;

struct QuantisedCloud {
  Cloud cloud;
  double error_bound = 0;  ///< meters: no coordinate is farther than this from the one that was encoded
};

/// Every coordinate of a finite point within `error_bound` meters, the order of the points, their colors and which of
/// them are finite kept exactly; points that are not finite come back as NaN, black. A coordinate above 0 stays above
/// 0. INVALID_ARGUMENT for a bound outside of the range above, or coordinates so large that floats cannot keep it.
absl::StatusOr<std::string> encode_quantised(const CloudView& cloud, double error_bound);

/// The same bytes give the same cloud on every CPU. INVALID_ARGUMENT that names the fault of the bytes or the limit.
absl::StatusOr<QuantisedCloud> decode_quantised(std::string_view bytes, const View& view, const DecodeLimits& limits,
                                                const StopToken& stop = {});

}  // namespace segserve::codec
