// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

#include "absl/status/statusor.h"

namespace segserve::wire {

/// The ways in which a cloud can be sent. Receivers tell them from the message.
enum class Codec : std::uint8_t {
  kPlanar,       ///< a plane of floats per coordinate and one of colors; lossless
  kPlanarZstd,   ///< the same, compressed
  kStrided,      ///< the layout of sensor_msgs/PointCloud2; lossless
  kStridedZstd,  ///< the same, compressed
  kQuantised,    ///< a grid with an error bound (core/codec/quantised/FORMAT.md)
  kPcd,          ///< a PCD file, binary_compressed; lossless
  kRgbd,         ///< the images of a pinhole camera: PNG depth, JPEG color
  kDraco,        ///< Google's Draco with an error bound; servers accept it only if their operator says so
};

/// The codec of a name such as "planar-zstd". INVALID_ARGUMENT that lists the names there are.
absl::StatusOr<Codec> codec_from_name(std::string_view name);

struct CodecOptions {
  Codec codec = Codec::kPlanar;
  double error_bound = 0.001;  ///< of a coordinate, meters; kQuantised and kDraco
  int jpeg_quality = 90;       ///< of the colors, 1 to 100; kRgbd
};

}  // namespace segserve::wire
