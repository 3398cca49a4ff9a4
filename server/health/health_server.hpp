// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "grpcpp/server.h"
#include "server/health/health_service.hpp"
#include "server/health/health_state.hpp"
#include "server/listener/address_claim.hpp"
#include "server/options/listen_address.hpp"

namespace segserve::server {

/// A server of gRPC that answers grpc.health.v1 and nothing else, in plain text. It is for probes that have neither
/// certificates nor tokens.
class HealthServer {
 public:
  /// UNAVAILABLE says why the address cannot be bound. `state` must outlive the server.
  static absl::StatusOr<std::unique_ptr<HealthServer>> start(const ListenAddress& address, HealthState& state);

  ~HealthServer();
  HealthServer(const HealthServer&) = delete;
  HealthServer& operator=(const HealthServer&) = delete;

  /// The address, with the port that was picked for port 0.
  const std::string& address() const { return address_; }
  /// 0 for a unix socket.
  int port() const { return port_; }

 private:
  HealthServer(HealthState& state, AddressClaim claim) : service_(state), claim_(std::move(claim)) {}

  HealthService service_;
  AddressClaim claim_;
  std::unique_ptr<grpc::Server> server_;  // is destroyed before the service that it calls
  std::string address_;
  int port_ = 0;
};

}  // namespace segserve::server
