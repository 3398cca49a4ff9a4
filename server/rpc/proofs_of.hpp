// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "grpcpp/server_context.h"
#include "server/access/access_control.hpp"

namespace segserve::server {

/// Finds the proofs of identity that this call brings. The context must outlive the use.
PresentedProofs proofs_of(const grpc::CallbackServerContext& context);

}  // namespace segserve::server
