// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

#include "absl/status/statusor.h"

namespace segserve::wire {

/// How a cloud is encoded when it is sent. A receiver sees from the message which codec was used. Every codec keeps the
/// order of the points and which of them are finite.
enum class Codec : std::uint8_t {
  kPlanar,       ///< one plane of floats per coordinate and one plane of colors; lossless
  kPlanarZstd,   ///< as kPlanar, with every plane compressed by Zstandard; lossless
  kStrided,      ///< point by point, in the layout of sensor_msgs/PointCloud2; lossless
  kStridedZstd,  ///< as kStrided, compressed by Zstandard; lossless
  kQuantised,    ///< coordinates on a grid, within an error bound (core/codec/quantised/FORMAT.md); colors are exact
  kPcd,          ///< a PCD file, binary_compressed; lossless
  kRgbd,         ///< a 16-bit PNG of the depth and a JPEG of the colors; organized clouds of a pinhole camera only
  kDraco,        ///< Google's Draco, within an error bound; a server accepts it only if its operator enables it
};

/// The codec with a name such as "planar-zstd". INVALID_ARGUMENT if this build has no such codec; the message lists the
/// names of those that it has.
absl::StatusOr<Codec> codec_from_name(std::string_view name);

/// A codec and its parameters. A codec ignores the parameters of the others.
struct CodecOptions {
  Codec codec = Codec::kPlanar;
  double error_bound = 0.001;  ///< largest error of a coordinate, meters; kQuantised and kDraco
  int jpeg_quality = 90;       ///< quality of the colors, 1 to 100; kRgbd
};

}  // namespace segserve::wire
