// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "grpcpp/server_builder.h"
#include "server/listener/call_flood.hpp"

namespace segserve::server {

/// Makes a server of gRPC tell of each call, whatever its method: when it arrives, in the thread that reads the
/// connection, when it begins after it has waited for its turn, and when it ends. Messages cost nothing. `on_flood`
/// gets the peer of a connection that floods the server, as gRPC names it, at each of its calls. `flood` must outlive
/// the server.
void count_calls(grpc::ServerBuilder& builder, CallFlood& flood, std::function<void(const std::string& peer)> on_flood);

}  // namespace segserve::server
