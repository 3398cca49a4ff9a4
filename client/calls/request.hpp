#pragma once

#include "absl/status/statusor.h"
#include "segserve/client/client.hpp"

namespace segserve::client {

/// The request for a cloud, encoded and compressed as `call` says. INVALID_ARGUMENT if it exceeds
/// wire::kMaxRequestBytes even so, the cloud's planes do not fit each other, or the codec cannot encode it.
absl::StatusOr<v1::SegmentRequest> cloud_request(const CloudView& cloud, const Options& options,
                                                 const CallOptions& call);

/// The same for a cloud that is encoded already.
absl::StatusOr<v1::SegmentRequest> payload_request(const Payload& payload, const Options& options,
                                                   const CallOptions& call);

}  // namespace segserve::client
