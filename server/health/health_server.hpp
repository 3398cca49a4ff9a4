// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "grpcpp/server.h"
#include "grpcpp/server_builder.h"
#include "server/health/health_service.hpp"
#include "server/health/health_state.hpp"
#include "server/listener/address_claim.hpp"
#include "server/listener/grpc_port.hpp"
#include "server/options/listen_address.hpp"

namespace segserve::server {

/// A server of gRPC that answers grpc.health.v1 and nothing else, in plain text. It is for probes that have neither
/// certificates nor tokens. A port has a bounded number of connections, so that probes take no descriptors from others.
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
  int port() const { return port_ ? port_->port() : 0; }

  /// Counts the connections that were accepted so far; null for a unix socket.
  std::function<std::uint64_t()> accepted() const {
    if (!port_) return nullptr;
    return [this] { return port_->accepted(); };
  }

 private:
  HealthServer(HealthState& state, AddressClaim claim) : service_(state), claim_(std::move(claim)) {}

  /// These start the server. False if the address cannot be bound.
  bool listen_at_path(grpc::ServerBuilder& builder);
  bool listen_at_port(grpc::ServerBuilder& builder, const ListenAddress& address);

  HealthService service_;
  AddressClaim claim_;
  std::unique_ptr<GrpcPort> port_;        // gRPC listens at paths itself
  std::unique_ptr<grpc::Server> server_;  // is destroyed before the service and the port that it calls
  std::string address_;
};

}  // namespace segserve::server
