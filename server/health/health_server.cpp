// SPDX-License-Identifier: Apache-2.0
#include "server/health/health_server.hpp"

#include <chrono>
#include <cstddef>
#include <utility>

#include "core/base/status_macros.hpp"
#include "fmt/format.h"
#include "grpcpp/resource_quota.h"
#include "grpcpp/security/server_credentials.h"
#include "server/listener/file_descriptors.hpp"

namespace segserve::server {
namespace {

// Probes are small, few and short.
constexpr int kMostProbeBytes = 4096;
constexpr int kMostProbesPerConnection = 16;
constexpr int kMostProbeMetadataBytes = 8 * 1024;
// A connection that has brought no HTTP/2 after this time is closed, and so is one without calls.
constexpr int kProbeHandshakeMs = 5'000, kProbeIdleMs = 30'000;
constexpr std::size_t kMostProbeConnections = 64;
constexpr std::size_t kProbeTransportBytes = std::size_t{16} << 20U;
constexpr std::chrono::milliseconds kProbeCloseTime{100};

}  // namespace

absl::StatusOr<std::unique_ptr<HealthServer>> HealthServer::start(const ListenAddress& address, HealthState& state) {
  ASSIGN_OR_RETURN(AddressClaim claim, AddressClaim::take(address));
  std::unique_ptr<HealthServer> server(new HealthServer(state, std::move(claim)));
  grpc::ResourceQuota quota("health");
  quota.Resize(kProbeTransportBytes);
  grpc::ServerBuilder builder;
  builder.SetResourceQuota(quota);
  builder.SetMaxReceiveMessageSize(kMostProbeBytes);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, kMostProbesPerConnection);
  builder.AddChannelArgument(GRPC_ARG_MAX_METADATA_SIZE, kMostProbeMetadataBytes);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_IDLE_MS, kProbeIdleMs);
  builder.AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, kProbeHandshakeMs);
  builder.RegisterService(&server->service_);
  const bool listens = address.is_unix ? server->listen_at_path(builder) : server->listen_at_port(builder, address);
  if (!listens) {
    return absl::UnavailableError(
        fmt::format("cannot listen for probes on {}: {}", server->claim_.bind_address(), why_not_bindable(address)));
  }
  RETURN_IF_ERROR(server->claim_.publish());
  server->address_ = with_port(address, server->port());
  return server;
}

bool HealthServer::listen_at_path(grpc::ServerBuilder& builder) {
  builder.AddListeningPort(claim_.bind_address(), grpc::InsecureServerCredentials());
  server_ = builder.BuildAndStart();
  return server_ != nullptr;
}

bool HealthServer::listen_at_port(grpc::ServerBuilder& builder, const ListenAddress& address) {
  auto port = GrpcPort::open(address, builder, grpc::InsecureServerCredentials());
  if (!port.ok()) return false;
  port_ = *std::move(port);
  server_ = builder.BuildAndStart();
  return server_ &&
         port_->start(connections_beside_grpc(kMostProbeConnections, BoundedAcceptor::kDescriptorsOfConnection)).ok();
}

HealthServer::~HealthServer() {
  if (!server_) return;
  claim_.release();
  if (port_) port_->close();
  server_->Shutdown(std::chrono::system_clock::now() + kProbeCloseTime);
  server_->Wait();
}

}  // namespace segserve::server
