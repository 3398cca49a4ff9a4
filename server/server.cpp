// SPDX-License-Identifier: Apache-2.0
#include "server/server.hpp"

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/status_macros.hpp"
#include "fmt/format.h"
#include "grpcpp/ext/proto_server_reflection_plugin.h"
#include "grpcpp/grpcpp.h"
#include "grpcpp/health_check_service_interface.h"
#include "grpcpp/impl/server_builder_option.h"
#include "grpcpp/impl/server_builder_plugin.h"
#include "grpcpp/resource_quota.h"
#include "proto/wire/status_message.hpp"
#include "proto/wire/transport_limits.hpp"
#include "server/listener/listener_probe.hpp"
#include "server/memory/memory_ledger.hpp"
#include "server/options/listen_address.hpp"
#include "server/rpc/segmentation_service.hpp"
#include "spdlog/spdlog.h"

namespace segserve::server {
namespace {

// The transport needs bounds of its own, because a unary request is in memory before our code sees it.
constexpr int kMaxStreamsPerConnection = 128;
constexpr std::uint64_t kLeastTransportBytes = std::uint64_t{32} << 20U, kMostTransportBytes = std::uint64_t{1} << 30U;
// Open health watches end after this time; nothing else ends them.
constexpr std::chrono::milliseconds kCloseTime{100};
// Calls that are ended at the end of the grace period have this long to tell their clients.
constexpr std::chrono::milliseconds kAbortTime{500};
// A connection without calls is closed after this time.
constexpr int kConnectionIdleMs = 600'000;
// All headers of a call.
constexpr int kMetadataBytes = 16 * 1024;

/// gRPC would take a unix socket away from the process that serves on it.
bool is_served(const ListenAddress& address) {
  constexpr std::chrono::seconds kPatience{1};
  const Listener found = probe_listener(address, 0, kPatience);
  return found == Listener::kAnswers || found == Listener::kSilent;
}

/// Its library gives reflection to every server of a process that links it.
class WithoutReflection final : public grpc::ServerBuilderOption {
 public:
  void UpdateArguments(grpc::ChannelArguments* /*arguments*/) override {}
  void UpdatePlugins(std::vector<std::unique_ptr<grpc::ServerBuilderPlugin>>* plugins) override {
    std::erase_if(*plugins, [](const auto& plugin) { return plugin->name().find("reflection") != std::string::npos; });
  }
};

class GrpcServer final : public Server {
 public:
  GrpcServer(const ServerOptions& options, const BackendFactory& make_backend)
      : grace_period_(options.grace_period),
        drain_delay_(options.drain_delay),
        transport_bytes_(std::clamp(options.memory / 5, kLeastTransportBytes, kMostTransportBytes)),
        reflection_(options.reflection),
        service_(options, make_backend) {}
  GrpcServer(const GrpcServer&) = delete;
  GrpcServer& operator=(const GrpcServer&) = delete;
  ~GrpcServer() override { stop(); }

  absl::Status listen(const ListenAddress& address);

  const std::string& address() const override { return address_; }
  int port() const override { return port_; }
  std::size_t calls() const override { return service_.calls_in_flight(); }
  bool stop() override;

 private:
  const std::chrono::milliseconds grace_period_, drain_delay_;
  const std::uint64_t transport_bytes_;  // for what is on its way, besides the memory of frames
  const bool reflection_;
  SegmentationService service_;
  std::unique_ptr<grpc::Server> server_;  // is destroyed before the service that it calls
  std::string address_;
  int port_ = 0;
};

absl::Status GrpcServer::listen(const ListenAddress& address) {
  const std::string wanted = address.is_unix ? with_port(address, 0) : with_port(address, std::stoi(address.port));
  if (address.is_unix && is_served(address)) {
    return absl::UnavailableError(fmt::format("cannot listen on {}: another process serves there", wanted));
  }
  grpc::EnableDefaultHealthCheckService(true);
  grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  grpc::ResourceQuota quota("segserve");
  quota.Resize(transport_bytes_);

  grpc::ServerBuilder builder;
  if (!reflection_) builder.SetOption(std::make_unique<WithoutReflection>());
  builder.SetResourceQuota(quota);
  builder.SetMaxReceiveMessageSize(wire::kServerReceiveBytes);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, kMaxStreamsPerConnection);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_IDLE_MS, kConnectionIdleMs);
  builder.AddChannelArgument(GRPC_ARG_MAX_METADATA_SIZE, kMetadataBytes);
  // A small compressed message could be huge. Payloads have compression of their own, whose results are bounded.
  builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_GZIP, false);
  builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_DEFLATE, false);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_BDP_PROBE, 0);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_STREAM_LOOKAHEAD_BYTES, wire::kFlowControlBytes);
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);  // otherwise two servers could share a port without a word
  builder.AddListeningPort(wanted, grpc::InsecureServerCredentials(), &port_);
  builder.RegisterService(&service_);
  server_ = builder.BuildAndStart();
  if (!server_) {
    return absl::UnavailableError(fmt::format("cannot listen on {}: {}", wanted, why_not_bindable(address)));
  }
  if (address.is_unix) port_ = 0;
  address_ = with_port(address, port_);
  server_->GetHealthCheckService()->SetServingStatus(v1::SegmentationService::service_full_name(), true);
  return absl::OkStatus();
}

bool GrpcServer::stop() {
  if (!server_) return true;
  const auto begin = std::chrono::steady_clock::now();
  const auto deadline = begin + grace_period_;
  server_->GetHealthCheckService()->SetServingStatus(false);
  service_.start_draining();
  const bool all_finished = service_.wait_until_idle_or(deadline);
  if (!all_finished) {
    spdlog::warn("the grace period is over: ending {} calls", service_.calls_in_flight());
    service_.abort_calls();
    service_.wait_until_idle_or(std::chrono::steady_clock::now() + kAbortTime);
  }
  std::this_thread::sleep_until(std::min(deadline, begin + drain_delay_));
  server_->Shutdown(std::chrono::system_clock::now() + kCloseTime);
  server_->Wait();
  service_.wait_until_idle();
  server_.reset();
  return all_finished;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Server>> Server::start(ServerOptions options, const BackendFactory& make_backend) {
  RETURN_IF_ERROR(wire::invalid_fields(violations(options)));
  ASSIGN_OR_RETURN(const ListenAddress address, parse_listen_address(options.listen));
  if (options.workers == 0) options.workers = std::max(1U, std::thread::hardware_concurrency());
  if (options.memory == 0) options.memory = available_memory() / 4 * 3;
  auto server = std::make_unique<GrpcServer>(options, make_backend);
  RETURN_IF_ERROR(server->listen(address));
  return server;
}

}  // namespace segserve::server
