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
#include "server/listener/socket.hpp"

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

/// Listens where gRPC would: all addresses of IPv4 stand for all of IPv6, too, where there is IPv6.
absl::StatusOr<Socket> listen_as_grpc(const ListenAddress& address) {
  if (address.host == "0.0.0.0") {
    ListenAddress all = address;
    all.host = "::";
    if (absl::StatusOr<Socket> socket = listen_at(all); socket.ok()) return socket;
  }
  return listen_at(address);
}

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
  using Way = grpc::ServerBuilder::experimental_type::ExternalConnectionType;
  absl::StatusOr<Socket> listener = listen_as_grpc(address);
  if (!listener.ok()) return false;
  entry_ = builder.experimental().AddExternalConnectionAcceptor(Way::FROM_FD, grpc::InsecureServerCredentials());
  server_ = builder.BuildAndStart();
  if (!server_) return false;
  const std::size_t most = connections_beside_grpc(kMostProbeConnections, BoundedAcceptor::kDescriptorsOfConnection);
  auto acceptor = BoundedAcceptor::start(*std::move(listener), most, [this](Socket connection) {
    grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters parameters;
    parameters.fd = connection.release();
    entry_->HandleNewConnection(&parameters);
  });
  if (acceptor.ok()) acceptor_ = *std::move(acceptor);
  return acceptor_ != nullptr;
}

HealthServer::~HealthServer() {
  if (!server_) return;
  claim_.release();
  acceptor_.reset();
  server_->Shutdown(std::chrono::system_clock::now() + kProbeCloseTime);
  server_->Wait();
}

}  // namespace segserve::server
