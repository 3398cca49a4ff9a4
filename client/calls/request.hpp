// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "segserve/client/client.hpp"
#include "segserve/v1/segment.pb.h"

namespace segserve::client {

/// The request to segment a cloud, encoded and compressed as `call` says. INVALID_ARGUMENT if the planes of the cloud
/// do not fit each other or the codec cannot encode it; with the reason LIMIT_EXCEEDED if the request exceeds
/// wire::kMaxRequestBytes all the same.
absl::StatusOr<v1::SegmentRequest> cloud_request(const CloudView& cloud, const Options& options,
                                                 const CallOptions& call);

/// The request to segment a cloud that is encoded already. INVALID_ARGUMENT, LIMIT_EXCEEDED if it exceeds
/// wire::kMaxRequestBytes.
absl::StatusOr<v1::SegmentRequest> payload_request(const Payload& payload, const Options& options,
                                                   const CallOptions& call);

}  // namespace segserve::client
