// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace segserve::tracking {

/// The largest number of a state: meters, m/s and square meters. States beyond it are refused, so none is made.
inline constexpr double kFarthest = 1e9;
/// The largest coordinate of an axis. Those of unit vectors are smaller; a state may be rounded.
inline constexpr double kLongestAxis = 2;

}  // namespace segserve::tracking
