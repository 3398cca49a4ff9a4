// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "grpcpp/server_context.h"
#include "server/observe/frame_record.hpp"

namespace segserve::server {

/// Who made this call, as far as its connection and its metadata tell. `subject` is who the caller has proved to be.
Caller caller_of(const grpc::CallbackServerContext& context, std::string subject = "");

}  // namespace segserve::server
