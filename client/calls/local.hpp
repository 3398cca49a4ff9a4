// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "proto/wire/request_message.hpp"
#include "proto/wire/result_message.hpp"
#include "segserve/client/payload.hpp"
#include "segserve/options.hpp"
#include "segserve/prompts.hpp"
#include "segserve/stop_token.hpp"
#include "segserve/wire/tracks.hpp"

namespace segserve::client {

/// Segments a cloud in this process as a server would. The result holds all arrays, and the statistics of the segments
/// if `outputs` asks for them. It holds what `prompts` select, and with `tracking` the ids of the segments;
/// INVALID_ARGUMENT tells their faults. `view_rule` says why the cloud has its view. Fails as segserve::segment does,
/// and turns exceptions into RESOURCE_EXHAUSTED (no memory) or INTERNAL.
absl::StatusOr<wire::Result> segment_here(const CloudView& cloud, const std::string& view_rule, const Options& options,
                                          const wire::Outputs& outputs, const StopToken& stop,
                                          const std::optional<Prompts>& prompts = std::nullopt,
                                          const std::optional<wire::TrackRequest>& tracking = std::nullopt);

/// Does the same for the cloud that a server would decode.
absl::StatusOr<wire::Result> segment_here(const Payload& payload, const Options& options, const wire::Outputs& outputs,
                                          const StopToken& stop, const std::optional<Prompts>& prompts = std::nullopt,
                                          const std::optional<wire::TrackRequest>& tracking = std::nullopt);

}  // namespace segserve::client
