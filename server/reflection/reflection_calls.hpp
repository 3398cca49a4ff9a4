// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <list>
#include <memory>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "core/base/mutex.hpp"
#include "grpcpp/server_context.h"
#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/server_callback.h"

namespace segserve::server {

class ReflectionCalls;

/// One call of ServerReflectionInfo: reads a request, writes its answer, and reads the next one then, so that it never
/// holds more than one answer. The object owns itself from `start` to OnDone.
class ReflectionCall final : public grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>,
                             public std::enable_shared_from_this<ReflectionCall> {
 public:
  explicit ReflectionCall(ReflectionCalls& calls) : calls_(calls) {}

  void start();
  void finish(const grpc::Status& status);

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

 private:
  void read();

  ReflectionCalls& calls_;
  std::shared_ptr<ReflectionCall> self_;
  grpc::ByteBuffer request_, response_;  // gRPC's while a read or a write is under way
  Mutex mutex_;
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
};

/// The calls of a server. There are few at a time: one more ends the oldest, so that nobody can keep others out by
/// calls that do nothing. Thread-safe.
class ReflectionCalls {
 public:
  /// Says whether a caller may ask; its status ends the call unless it is OK.
  using Permit = std::function<absl::Status(const grpc::CallbackServerContext&)>;

  explicit ReflectionCalls(Permit permit) : permit_(std::move(permit)) {}

  /// Begins a call. Returns it for gRPC.
  ReflectionCall* begin(const grpc::CallbackServerContext& context);
  /// Ends all calls, and later ones at once.
  void close();
  void remove(const std::shared_ptr<ReflectionCall>& call);

 private:
  const Permit permit_;
  Mutex mutex_;
  std::list<std::shared_ptr<ReflectionCall>> calls_ ABSL_GUARDED_BY(mutex_);  // the oldest first
  bool closed_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace segserve::server
