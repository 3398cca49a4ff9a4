// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "grpcpp/server.h"
#include "grpcpp/server_builder.h"
#include "server/health/health_service.hpp"
#include "server/health/health_state.hpp"
#include "server/listener/address_claim.hpp"
#include "server/listener/bounded_acceptor.hpp"
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
  int port() const { return acceptor_ ? acceptor_->port() : 0; }

 private:
  HealthServer(HealthState& state, AddressClaim claim) : service_(state), claim_(std::move(claim)) {}

  /// These start the server. False if the address cannot be bound.
  bool listen_at_path(grpc::ServerBuilder& builder);
  bool listen_at_port(grpc::ServerBuilder& builder, const ListenAddress& address);

  HealthService service_;
  AddressClaim claim_;
  std::unique_ptr<grpc::Server> server_;  // is destroyed before the service that it calls
  std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> entry_;
  std::unique_ptr<BoundedAcceptor> acceptor_;  // of a port; gRPC listens at paths itself
  std::string address_;
};

}  // namespace segserve::server
