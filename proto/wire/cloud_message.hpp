// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "proto/wire/byte_run.hpp"
#include "segserve/cloud.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/codec/rgbd_encode.hpp"
#include "segserve/options.hpp"
#include "segserve/v1/cloud.pb.h"

namespace segserve::wire {

v1::View to_message(const View& view);

/// The view of a message; nullopt if its kind is UNSPECIFIED. Appends what is wrong with it to `faults`, by
/// path below "cloud.view".
std::optional<View> from_message(const v1::View& message, std::vector<FieldViolation>& faults);

/// The cloud as planar raw, each plane compressed if so asked. By other codecs: wire/codec.hpp.
absl::StatusOr<v1::Cloud> to_planar_message(const CloudView& cloud, v1::Compression compression);

/// A cloud on its way out.
struct OutgoingCloud {
  v1::Cloud message;  ///< without the bytes of its blocks
  std::shared_ptr<const ByteRun> bytes;
};

/// The cloud as planar raw, its coordinates sent from where they are. `cloud` must not change as long as the bytes are
/// shared.
OutgoingCloud share_planar(std::shared_ptr<const Cloud> cloud);

/// A PCD file as it is; the view, if given, overrides the file's.
v1::Cloud to_pcd_message(std::string file_bytes, std::optional<View> view);

/// The images of an RGB-D camera as they are. Their shape is in the message if the depth's header tells it.
v1::Cloud to_rgbd_message(codec::RgbdFiles images);

/// Every fault of the fields around the payload: no payload, no view or no shape where one is needed.
std::vector<FieldViolation> violations(const v1::Cloud& message);

struct DecodedCloud {
  BorrowingCloud cloud;   ///< planes may lie in the message, which must outlive it
  std::string view_rule;  ///< one line for people: why this view
};

/// The payload's cloud. Sizes it claims are checked against the limits before anything is allocated.
/// INVALID_ARGUMENT: INVALID_FIELD (also for a kind that is not enabled: see check_kind), MALFORMED_PAYLOAD, or
/// LIMIT_EXCEEDED. The status of `stop` once it says so.
absl::StatusOr<DecodedCloud> decode_cloud(const v1::Cloud& message, const codec::DecodeLimits& limits,
                                          const StopToken& stop = {});
absl::StatusOr<DecodedCloud> decode_cloud(const v1::Cloud&& message, const codec::DecodeLimits& limits,
                                          const StopToken& stop = {}) = delete;  // the message would be gone

}  // namespace segserve::wire
