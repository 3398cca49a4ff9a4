// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mutex>

#include "grpcpp/server_context.h"

namespace segserve::server {

/// Lets any thread cancel a call as long as gRPC keeps its context. Thread-safe.
class CallCanceler {
 public:
  explicit CallCanceler(grpc::CallbackServerContext& context) : context_(&context) {}

  /// Ends the call from this side, whatever it waits for.
  void cancel() {
    const std::lock_guard lock(mutex_);
    if (context_ != nullptr) context_->TryCancel();
  }
  /// The reactor's OnDone calls this first, because the context is gone after it.
  void forget() {
    const std::lock_guard lock(mutex_);
    context_ = nullptr;
  }

 private:
  std::recursive_mutex mutex_;  // gRPC may call OnDone within TryCancel.
  grpc::CallbackServerContext* context_;
};

}  // namespace segserve::server
