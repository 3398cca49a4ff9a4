#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "absl/status/statusor.h"
#include "segserve/cloud/cloud.hpp"
#include "segserve/codec/limits.hpp"
#include "segserve/v1alpha1/cloud.pb.h"
#include "segserve/wire/cloud.hpp"

// Each kind of payload in a file of its own: what its message holds, into a cloud. For wire/cloud.cpp alone. The fields
// around the payload have been checked (wire::violations). Errors as those of wire::decode_cloud.
namespace segserve::wire {

absl::StatusOr<DecodedCloud> decode_planar(const v1alpha1::Cloud& message, const std::optional<View>& view,
                                           const codec::DecodeLimits& limits);
absl::StatusOr<DecodedCloud> decode_pcd_file(const v1alpha1::Cloud& message, const std::optional<View>& view,
                                             const codec::DecodeLimits& limits);

}  // namespace segserve::wire
