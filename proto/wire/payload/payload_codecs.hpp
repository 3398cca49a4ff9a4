// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "absl/status/statusor.h"
#include "proto/wire/cloud_message.hpp"
#include "segserve/cloud.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/v1/cloud.pb.h"

// Each kind of payload in a file of its own: a message's payload into a cloud and back. For wire/cloud.cpp and
// wire/codec.cpp alone, which choose by kind.
namespace segserve::wire {

// The fields around the payload have been checked (wire::violations); `view` is set unless the payload has its own.
// Errors as those of wire::decode_cloud.
absl::StatusOr<DecodedCloud> decode_planar(const v1::Cloud& message, const std::optional<View>& view,
                                           const codec::DecodeLimits& limits, const StopToken& stop);
absl::StatusOr<DecodedCloud> decode_pcd_file(const v1::Cloud& message, const std::optional<View>& view,
                                             const codec::DecodeLimits& limits, const StopToken& stop);
absl::StatusOr<DecodedCloud> decode_strided(const v1::Cloud& message, const std::optional<View>& view,
                                            const codec::DecodeLimits& limits, const StopToken& stop);
absl::StatusOr<DecodedCloud> decode_quantised(const v1::Cloud& message, const std::optional<View>& view,
                                              const codec::DecodeLimits& limits, const StopToken& stop);
absl::StatusOr<DecodedCloud> decode_rgbd(const v1::Cloud& message, const std::optional<View>& view,
                                         const codec::DecodeLimits& limits, const StopToken& stop);
absl::StatusOr<DecodedCloud> decode_draco(const v1::Cloud& message, const std::optional<View>& view,
                                          const codec::DecodeLimits& limits, const StopToken& stop);

// Errors as those of wire::to_message. Planar and PCD: wire/cloud.hpp.
absl::StatusOr<v1::Cloud> to_strided_message(const CloudView& cloud, v1::Compression compression);
absl::StatusOr<v1::Cloud> to_quantised_message(const CloudView& cloud, double error_bound);
absl::StatusOr<v1::Cloud> to_rgbd_message(const CloudView& cloud, int jpeg_quality);
absl::StatusOr<v1::Cloud> to_draco_message(const CloudView& cloud, double error_bound);

}  // namespace segserve::wire
