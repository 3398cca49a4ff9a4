// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/status.h"
#include "grpcpp/support/status.h"
#include "proto/wire/status_message.hpp"

namespace segserve::server {

/// The status that ends a call. There is always one, so that no call hangs: without memory for its details and text, it
/// is a bare INTERNAL.
inline grpc::Status final_status(const absl::Status& status) noexcept {
  try {
    return wire::to_grpc(status);
  } catch (...) {
    return {grpc::StatusCode::INTERNAL, ""};
  }
}

}  // namespace segserve::server
