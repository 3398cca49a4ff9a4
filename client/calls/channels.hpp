// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "core/base/mutex.hpp"
#include "grpcpp/channel.h"

namespace segserve::client {

/// One gRPC channel for each address. Any number of threads may use it. Channels of different objects share no
/// connection.
class Channels {
 public:
  /// Channels are made when they are used first. `use_proxy` as in ClientOptions.
  Channels(std::vector<std::string> addresses, bool use_proxy);
  /// Uses a channel that the caller made; `address` serves messages only.
  Channels(std::string address, std::shared_ptr<grpc::Channel> channel);

  const std::vector<std::string>& addresses() const { return addresses_; }
  std::shared_ptr<grpc::Channel> get(std::size_t address) ABSL_LOCKS_EXCLUDED(mutex_);
  /// Replaces a channel whose connection the network has cut, unless that was done before. Calls on it go on. A channel
  /// that the caller made stays.
  void renew(std::size_t address, const std::shared_ptr<grpc::Channel>& cut) ABSL_LOCKS_EXCLUDED(mutex_);
  /// Returns 0, 1, 2 and so on: where the next user may begin, so that users spread over the addresses.
  std::size_t next_start() ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  const std::vector<std::string> addresses_;
  const bool made_here_;
  const bool use_proxy_;
  Mutex mutex_;
  std::vector<std::shared_ptr<grpc::Channel>> channels_ ABSL_GUARDED_BY(mutex_);  // null until they are used
  std::size_t starts_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace segserve::client
