#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "proto/wire/request_message.hpp"
#include "proto/wire/result_message.hpp"
#include "segserve/client/payload.hpp"
#include "segserve/options.hpp"
#include "segserve/stop_token.hpp"

namespace segserve::client {

/// What a server would answer, computed in this process by the same core: all arrays, and the segments' statistics if
/// `outputs` asks for them. Errors as `segment`.
absl::StatusOr<wire::Result> segment_here(const CloudView& cloud, const std::string& view_rule, const Options& options,
                                          const wire::Outputs& outputs, const StopToken& stop);

/// The same on what a server would decode.
absl::StatusOr<wire::Result> segment_here(const Payload& payload, const Options& options, const wire::Outputs& outputs,
                                          const StopToken& stop);

}  // namespace segserve::client
