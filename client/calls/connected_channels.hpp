// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "absl/status/statusor.h"
#include "client/calls/channels.hpp"
#include "segserve/client/client.hpp"

namespace segserve::client {

/// The channels that the options describe. Errors as of Client::connect.
absl::StatusOr<std::shared_ptr<Channels>> make_channels(const ClientOptions& options);

}  // namespace segserve::client
