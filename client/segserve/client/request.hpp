#pragma once

#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "segserve/client/client.hpp"

namespace segserve::client {

/// The request for a cloud, compressed as `call` says. INVALID_ARGUMENT if it exceeds
/// wire::kMaxRequestBytes even so, or the cloud's planes do not fit each other.
absl::StatusOr<v1alpha1::SegmentRequest> planar_request(const CloudView& cloud, const Options& options,
                                                        const CallOptions& call);

/// The same for a PCD file.
absl::StatusOr<v1alpha1::SegmentRequest> pcd_request(std::string file_bytes, std::optional<View> view,
                                                     const Options& options, const CallOptions& call);

}  // namespace segserve::client
