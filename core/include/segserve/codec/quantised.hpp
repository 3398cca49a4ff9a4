// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/stop_token.hpp"

// Clouds whose coordinates are rounded to a grid. core/codec/quantised/FORMAT.md describes the format byte by byte.
namespace segserve::codec {

/// The error bounds that the format allows, meters: 0.1 to 10 mm.
inline constexpr double kMinErrorBound = 0.0001;
inline constexpr double kMaxErrorBound = 0.01;

/// A decoded cloud and what its bytes say of its precision.
struct QuantisedCloud {
  Cloud cloud;
  double error_bound = 0;  ///< meters: no coordinate is farther than this from the one that was encoded
};

/// Encodes a cloud. The decoded cloud has every coordinate of a finite point within `error_bound` meters, and a
/// coordinate above 0 stays above 0. The order of the points, which of them are finite, and the colors of the finite
/// ones are kept exactly; points that are not finite become NaN and black. The view is not part of the bytes.
/// INVALID_ARGUMENT if the bound is outside of [kMinErrorBound, kMaxErrorBound], or if a coordinate is so large that a
/// float cannot keep the bound.
absl::StatusOr<std::string> encode_quantised(const CloudView& cloud, double error_bound);

/// Decodes a cloud. The same bytes give the same cloud on every CPU. Coordinates are in the frame of `view`, which
/// becomes the view of the cloud. INVALID_ARGUMENT that names the fault of the bytes or the exceeded limit. CANCELLED
/// and DEADLINE_EXCEEDED as `stop` says.
absl::StatusOr<QuantisedCloud> decode_quantised(std::string_view bytes, const View& view, const DecodeLimits& limits,
                                                const StopToken& stop = {});

}  // namespace segserve::codec
