// SPDX-License-Identifier: Apache-2.0
#include "server/health/health_server.hpp"

#include <chrono>
#include <cstddef>
#include <utility>

#include "core/base/status_macros.hpp"
#include "fmt/format.h"
#include "grpcpp/resource_quota.h"
#include "grpcpp/security/server_credentials.h"
#include "grpcpp/server_builder.h"

namespace segserve::server {
namespace {

// Probes are small, few and short.
constexpr int kMostProbeBytes = 4096;
constexpr int kMostProbesPerConnection = 16;
constexpr int kMostProbeMetadataBytes = 8 * 1024;
constexpr int kProbeIdleMs = 120'000;
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
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);  // otherwise two servers could share a port without a word
  builder.AddListeningPort(server->claim_.bind_address(), grpc::InsecureServerCredentials(), &server->port_);
  builder.RegisterService(&server->service_);
  server->server_ = builder.BuildAndStart();
  if (!server->server_) {
    return absl::UnavailableError(
        fmt::format("cannot listen for probes on {}: {}", server->claim_.bind_address(), why_not_bindable(address)));
  }
  RETURN_IF_ERROR(server->claim_.publish());
  if (address.is_unix) server->port_ = 0;
  server->address_ = with_port(address, server->port_);
  return server;
}

HealthServer::~HealthServer() {
  if (!server_) return;
  claim_.release();
  server_->Shutdown(std::chrono::system_clock::now() + kProbeCloseTime);
  server_->Wait();
}

}  // namespace segserve::server
