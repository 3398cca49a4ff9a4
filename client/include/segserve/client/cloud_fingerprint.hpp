// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "segserve/cloud.hpp"

namespace segserve::client {

/// Tells clouds apart that have the same number of points: two different ones have the same checksum with a probability
/// of 1 in 4 billion. It does not depend on the file format, on the codec, on the view, or on rows and columns. It
/// protects against mistakes, not against forgery.
struct CloudFingerprint {
  /// CRC-32 of x, y and z of every point, in this order, as IEEE floats of 4 bytes with the least one first. A point
  /// that is not finite counts as three times the quiet NaN 0x7fc00000.
  std::uint32_t coordinates = 0;
  /// CRC-32 of the color of every point as 4 bytes blue, green, red, 0; 0 for a cloud without color.
  std::uint32_t colors = 0;

  bool operator==(const CloudFingerprint&) const = default;
};

/// The fingerprint of the points as they are given, which is before any codec.
CloudFingerprint fingerprint(const CloudView& cloud);

}  // namespace segserve::client
