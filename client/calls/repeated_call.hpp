// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <memory>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "client/calls/channels.hpp"
#include "grpcpp/channel.h"
#include "grpcpp/client_context.h"
#include "segserve/client/client.hpp"

namespace segserve::client {

/// Makes a unary call on a channel, in a context that has its deadline.
using Attempt = absl::FunctionRef<grpc::Status(const std::shared_ptr<grpc::Channel>&, grpc::ClientContext&)>;

/// Attempts a unary call at one address after the other until one answers or another try is in vain, at most for
/// `timeout`. Returns the status of the last attempt.
absl::Status repeat_call(Channels& channels, const ClientOptions& options, std::chrono::milliseconds timeout,
                         Attempt attempt);

}  // namespace segserve::client
