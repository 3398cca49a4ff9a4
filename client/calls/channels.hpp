// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/calls/token_source.hpp"
#include "client/fleet/call_turns.hpp"
#include "client/fleet/fleet.hpp"
#include "client/fleet/server_list.hpp"
#include "client/tls/tls_source.hpp"
#include "core/base/mutex.hpp"
#include "grpcpp/channel.h"
#include "grpcpp/client_context.h"

namespace segserve::client {

/// The servers of a client, and one gRPC channel for each. Any number of threads may use it. Channels of different
/// objects share no connection.
class Channels {
 public:
  /// Channels are made when they are used first. `use_proxy` as in ClientOptions: the proxy then looks up names.
  /// Without `tls` they are plain text, and without `token` calls get none.
  Channels(const std::vector<std::string>& addresses, bool use_proxy, std::optional<TlsSource> tls = std::nullopt,
           std::shared_ptr<TokenSource> token = nullptr);
  /// Uses a channel that the caller made; `address` serves messages only.
  Channels(const std::string& address, std::shared_ptr<grpc::Channel> channel);

  Fleet& fleet() { return fleet_; }
  /// Whose turn it is to get a unary call.
  CallTurns& turns() { return turns_; }
  /// If the files of TLS have changed, it is a new channel.
  std::shared_ptr<grpc::Channel> get(const Server& server) ABSL_LOCKS_EXCLUDED(mutex_);
  /// Replaces a channel whose connection is cut or shall be used no more, unless that was done before. Calls on it go
  /// on. A channel that the caller made stays.
  void renew(const Server& server, const std::shared_ptr<grpc::Channel>& cut) ABSL_LOCKS_EXCLUDED(mutex_);
  /// Why a connection to one of the addresses fails, as far as it is a matter of TLS; OK if that is not found out
  /// within `timeout`. It makes a connection, and blocks.
  absl::Status handshake_fault(const std::string& address, std::chrono::milliseconds timeout)
      ABSL_LOCKS_EXCLUDED(mutex_);
  /// Adds the token, if there is one, to a call that has not begun.
  void authorize(grpc::ClientContext& call);

 private:
  void forget_others(const std::vector<Server>& servers) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::shared_ptr<grpc::Channel> given_;  // by the caller; null: channels are made here
  const bool use_proxy_;
  const std::shared_ptr<TokenSource> token_;  // null: calls get none
  Fleet fleet_;
  CallTurns turns_;
  Mutex mutex_;
  std::optional<TlsSource> tls_ ABSL_GUARDED_BY(mutex_);
  std::map<ServerId, std::shared_ptr<grpc::Channel>> channels_ ABSL_GUARDED_BY(mutex_);  // that were used
};

}  // namespace segserve::client
