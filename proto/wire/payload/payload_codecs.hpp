// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "absl/status/statusor.h"
#include "proto/wire/cloud_message.hpp"
#include "segserve/cloud.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/codec/read_options.hpp"
#include "segserve/v1/cloud.pb.h"

// The functions that decode and encode one kind of payload each; every kind has a source file of its own. Only
// cloud_message.cpp and codec_message.cpp include this header. They choose the function by kind.
namespace segserve::wire {

// The decoders expect that the fields around the payload have no wire::violations. `view`, or that of `options`, is the
// view that the message gives; it is set unless the payload has a view of its own. Decoders without `options` do not
// look at the unit: the caller converts what they return. Errors are those of wire::decode_cloud.
absl::StatusOr<DecodedCloud> decode_planar(const v1::Cloud& message, const std::optional<View>& view,
                                           const codec::DecodeLimits& limits, const StopToken& stop);
absl::StatusOr<DecodedCloud> decode_pcd_file(const v1::Cloud& message, const codec::ReadOptions& options,
                                             const codec::DecodeLimits& limits, const StopToken& stop);
absl::StatusOr<DecodedCloud> decode_strided(const v1::Cloud& message, const codec::ReadOptions& options,
                                            const codec::DecodeLimits& limits, const StopToken& stop);
absl::StatusOr<DecodedCloud> decode_quantised(const v1::Cloud& message, const std::optional<View>& view,
                                              const codec::DecodeLimits& limits, const StopToken& stop);
absl::StatusOr<DecodedCloud> decode_rgbd(const v1::Cloud& message, const std::optional<View>& view,
                                         const codec::DecodeLimits& limits, const StopToken& stop);
absl::StatusOr<DecodedCloud> decode_draco(const v1::Cloud& message, const std::optional<View>& view,
                                          const codec::DecodeLimits& limits, const StopToken& stop);

// The encoders. Errors are those of wire::to_message(cloud, codec_options). The encoders of planar clouds and PCD files
// are in cloud_message.hpp.
absl::StatusOr<v1::Cloud> to_strided_message(const CloudView& cloud, v1::Compression compression);
absl::StatusOr<v1::Cloud> to_quantised_message(const CloudView& cloud, double error_bound);
absl::StatusOr<v1::Cloud> to_rgbd_message(const CloudView& cloud, int jpeg_quality);
absl::StatusOr<v1::Cloud> to_draco_message(const CloudView& cloud, double error_bound);

}  // namespace segserve::wire
