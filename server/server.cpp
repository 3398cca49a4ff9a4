// SPDX-License-Identifier: Apache-2.0
#include "server/server.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/status_macros.hpp"
#include "fmt/format.h"
#include "grpcpp/grpcpp.h"
#include "grpcpp/health_check_service_interface.h"
#include "grpcpp/resource_quota.h"
#include "proto/wire/status_message.hpp"
#include "proto/wire/transport_limits.hpp"
#include "server/access/access_control.hpp"
#include "server/health/health_server.hpp"
#include "server/health/health_service.hpp"
#include "server/health/health_state.hpp"
#include "server/http/http_entrance.hpp"
#include "server/http/http_server.hpp"
#include "server/http/http_tls.hpp"
#include "server/listener/address_claim.hpp"
#include "server/listener/file_descriptors.hpp"
#include "server/listener/grpc_port.hpp"
#include "server/memory/memory_ledger.hpp"
#include "server/metrics/service_metrics.hpp"
#include "server/metrics/tls_metrics.hpp"
#include "server/options/host_name.hpp"
#include "server/options/listen_address.hpp"
#include "server/reflection/reflection_calls.hpp"
#include "server/reflection/reflection_service.hpp"
#include "server/rpc/segmentation_service.hpp"
#include "server/tls/tls_credentials.hpp"
#include "spdlog/spdlog.h"

namespace segserve::server {
namespace {

// The transport needs bounds of its own, because a unary request is in memory before our code sees it.
constexpr int kMaxStreamsPerConnection = 128;
constexpr std::size_t kMostConnections = 10'000;
constexpr std::uint64_t kLeastTransportBytes = std::uint64_t{32} << 20U, kMostTransportBytes = std::uint64_t{1} << 30U;
// With less memory than this, what clients send ahead would not fit beside the frames.
constexpr std::uint64_t kLeastMemoryForWideWindows = std::uint64_t{1} << 30U;
// The time that the remaining calls may take when the server closes.
constexpr std::chrono::milliseconds kCloseTime{100};
// Calls that are ended at the end of the grace period have this long to tell their clients.
constexpr std::chrono::milliseconds kAbortTime{500};
// A connection without calls is closed after this time.
constexpr int kConnectionIdleMs = 600'000;
// A client that connects and shakes no hands is cut after this time.
constexpr int kHandshakeMs = 20'000;
// All headers of a call.
constexpr int kMetadataBytes = 16 * 1024;

AccessOptions access_options(const ServerOptions& options) {
  return {.tokens = options.tokens,
          .jwt_keys = options.jwt_keys,
          .jwt_issuer = options.jwt_issuer,
          .jwt_audience = options.jwt_audience};
}

class GrpcServer final : public Server {
 public:
  GrpcServer(const ServerOptions& options, std::unique_ptr<AccessControl> access,
             std::shared_ptr<CertificateReloader> certificates, const BackendFactory& make_backend,
             ServiceObservers observers)
      : options_(options),
        certificates_(std::move(certificates)),
        transport_bytes_(std::clamp(options.memory / 5, kLeastTransportBytes, kMostTransportBytes)),
        service_(options, std::move(access), make_backend, std::move(observers)) {}
  GrpcServer(const GrpcServer&) = delete;
  GrpcServer& operator=(const GrpcServer&) = delete;
  ~GrpcServer() override { stop(); }

  absl::Status listen(const ListenAddress& address);
  /// Answers probes at an address of their own.
  absl::Status listen_for_probes(const ListenAddress& address);
  /// Lets Prometheus read the metrics at an address of their own.
  absl::Status serve_metrics(const ListenAddress& address, std::unique_ptr<ServiceMetrics> metrics);

  /// Opens the web entrance.
  absl::Status serve_http(const ListenAddress& address);

  const ServerOptions& options() const override { return options_; }
  const std::string& address() const override { return address_; }
  int port() const override { return port_; }
  int health_port() const override { return health_server_ ? health_server_->port() : 0; }
  int metrics_port() const override { return metrics_ ? metrics_->port() : 0; }
  int http_port() const override { return http_server_ ? http_server_->port() : 0; }
  std::vector<WatchedListener> listeners() const override;
  std::size_t calls() const override { return service_.calls_in_flight(); }
  void set_alive(bool alive) override { health_.set_alive(alive); }
  std::optional<TlsStatus> tls_status() const override {
    return certificates_ ? std::optional(certificates_->status()) : std::nullopt;
  }
  bool stop() override;

 private:
  const ServerOptions options_;
  const std::shared_ptr<CertificateReloader> certificates_;  // null: the server speaks plain text
  const std::uint64_t transport_bytes_;                      // for what is on its way, besides the memory of frames
  HealthState health_;
  SegmentationService service_;
  HealthService health_service_{health_};
  ReflectionCalls reflection_calls_{[this](const grpc::CallbackServerContext& context) {
    return service_.admit_question(context, "ServerReflectionInfo");
  }};
  ReflectionV1 reflection_v1_{reflection_calls_};
  ReflectionV1Alpha reflection_v1alpha_{reflection_calls_};
  std::shared_ptr<grpc::ServerCredentials> credentials_;
  std::unique_ptr<GrpcPort> grpc_port_;   // of a TCP address; gRPC listens at paths itself
  std::unique_ptr<grpc::Server> server_;  // is destroyed before the services and the port that it calls
  std::optional<AddressClaim> claim_;
  std::unique_ptr<HealthServer> health_server_;
  std::unique_ptr<ServiceMetrics> metrics_;  // is destroyed before the service that it asks
  std::unique_ptr<HttpEntrance> entrance_;   // likewise
  std::unique_ptr<HttpServer> http_server_;  // is destroyed before the entrance that it calls
  std::string address_;
  int port_ = 0;
};

absl::Status GrpcServer::listen(const ListenAddress& address) {
  ASSIGN_OR_RETURN(AddressClaim claim, AddressClaim::take(address));
  claim_.emplace(std::move(claim));
  grpc::EnableDefaultHealthCheckService(false);  // ours knows both addresses
  grpc::ResourceQuota quota("segserve");
  quota.Resize(transport_bytes_);

  grpc::ServerBuilder builder;
  builder.SetResourceQuota(quota);
  builder.SetMaxReceiveMessageSize(wire::kServerReceiveBytes);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, kMaxStreamsPerConnection);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_IDLE_MS, kConnectionIdleMs);
  if (const auto interval = options_.ping_interval; interval.count() > 0) {
    builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, static_cast<int>(interval.count()));
    builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, kConnectionIdleMs);  // a slow link may take its time
    builder.AddChannelArgument(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);          // any number
  }
  builder.AddChannelArgument(GRPC_ARG_MAX_METADATA_SIZE, kMetadataBytes);
  builder.AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, kHandshakeMs);
  // A small compressed message could be huge. Payloads have compression of their own, whose results are bounded.
  builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_GZIP, false);
  builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_DEFLATE, false);
  // By its probes gRPC lets each connection send 4 MiB and more ahead, which far clients need. Clients on this machine
  // are served as well by the first window of 64 KiB, and one that floods is then no burden for others.
  if (address.is_loopback() || options_.memory < kLeastMemoryForWideWindows) {
    builder.AddChannelArgument(GRPC_ARG_HTTP2_BDP_PROBE, 0);
  }
  builder.AddChannelArgument(GRPC_ARG_HTTP2_STREAM_LOOKAHEAD_BYTES, wire::kFlowControlBytes);
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);  // otherwise two servers could share a port without a word
  credentials_ = certificates_ ? tls_credentials(certificates_) : grpc::InsecureServerCredentials();
  absl::Status bound = absl::OkStatus();
  if (address.is_unix) {
    builder.AddListeningPort(claim_->bind_address(), credentials_);
  } else {
    auto port = GrpcPort::open(address, builder, credentials_);
    bound = port.status();
    if (port.ok()) grpc_port_ = *std::move(port);
  }
  builder.RegisterService(&service_);
  builder.RegisterService(&health_service_);
  if (options_.reflection) {
    builder.RegisterService(&reflection_v1_);
    builder.RegisterService(&reflection_v1alpha_);
  }
  if (bound.ok()) server_ = builder.BuildAndStart();
  if (!server_) {
    return absl::UnavailableError(
        fmt::format("cannot listen on {}: {}", claim_->bind_address(), why_not_bindable(address)));
  }
  RETURN_IF_ERROR(claim_->publish());
  if (grpc_port_) {
    port_ = grpc_port_->port();
    RETURN_IF_ERROR(
        grpc_port_->start(connections_of_grpc(kMostConnections, BoundedAcceptor::kDescriptorsOfConnection)));
  }
  address_ = with_port(address, port_);
  health_.set_ready(true);
  return absl::OkStatus();
}

std::vector<WatchedListener> GrpcServer::listeners() const {
  std::vector<WatchedListener> all;
  const auto add = [&all](const std::string& text, int port, std::function<std::uint64_t()> accepted) {
    auto address = parse_listen_address(text);
    if (address.ok()) all.push_back({*std::move(address), port, std::move(accepted)});
  };
  using Accepted = std::function<std::uint64_t()>;
  add(options_.listen, port_, grpc_port_ ? Accepted([this] { return grpc_port_->accepted(); }) : nullptr);
  if (health_server_) add(options_.health_listen, health_port(), health_server_->accepted());
  if (http_server_) add(options_.http, http_port(), [this] { return http_server_->accepted(); });
  return all;
}

absl::Status GrpcServer::listen_for_probes(const ListenAddress& address) {
  ASSIGN_OR_RETURN(health_server_, HealthServer::start(address, health_));
  spdlog::info("probes for health are answered on {}", health_server_->address());
  return absl::OkStatus();
}

absl::Status GrpcServer::serve_metrics(const ListenAddress& address, std::unique_ptr<ServiceMetrics> metrics) {
  if (certificates_) metrics->add(std::make_shared<TlsMetrics>([this] { return certificates_->status(); }));
  RETURN_IF_ERROR(metrics->serve(address, [this] { return service_.state(); }));
  metrics_ = std::move(metrics);
  spdlog::info("metrics are served at http://{}/metrics", with_port(address, metrics_->port()));
  return absl::OkStatus();
}

absl::Status GrpcServer::serve_http(const ListenAddress& address) {
  ASSIGN_OR_RETURN(const auto host_names, parse_host_names(options_.http_host));
  HttpEntrance::Metrics metrics;
  if (metrics_) metrics = [page = metrics_->page()] { return page->text(); };
  entrance_ =
      std::make_unique<HttpEntrance>(EntranceOptions{.max_body_bytes = options_.stream_bytes,
                                                     .allow_origin = options_.http_allow_origin,
                                                     .only_known_hosts = address.is_loopback() || !host_names.empty(),
                                                     .host_names = host_names},
                                     service_, health_, std::move(metrics));
  auto tls = certificates_ ? std::make_unique<HttpTls>(certificates_) : nullptr;
  const char* const scheme = certificates_ ? "https" : "http";
  HttpLimits limits;
  limits.connections = connections_beside_grpc(limits.connections);
  ASSIGN_OR_RETURN(http_server_, HttpServer::start(address, *entrance_, std::move(tls), limits));
  spdlog::info("the web entrance is at {}://{}/", scheme, with_port(address, http_server_->port()));
  return absl::OkStatus();
}

bool GrpcServer::stop() {
  if (!server_) return true;
  const auto begin = std::chrono::steady_clock::now();
  const auto deadline = begin + options_.grace_period;
  health_.set_ready(false);
  service_.start_draining();
  const bool all_finished = service_.wait_until_idle_or(deadline);
  if (!all_finished) {
    spdlog::warn("the grace period is over: ending {} calls", service_.calls_in_flight());
    service_.abort_calls();
    if (entrance_) entrance_->abort_frames();
    service_.wait_until_idle_or(std::chrono::steady_clock::now() + kAbortTime);
  }
  std::this_thread::sleep_until(std::min(deadline, begin + options_.drain_delay));
  health_.close();
  reflection_calls_.close();
  if (http_server_) http_server_->close();
  claim_->release();
  if (grpc_port_) grpc_port_->close();
  server_->Shutdown(std::chrono::system_clock::now() + kCloseTime);
  server_->Wait();
  service_.wait_until_idle();
  server_.reset();
  http_server_.reset();
  health_server_.reset();
  return all_finished;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Server>> Server::start(ServerOptions options, const BackendFactory& make_backend,
                                                      ServiceObservers observers) {
  RETURN_IF_ERROR(wire::invalid_fields(violations(options)));
  ASSIGN_OR_RETURN(const ListenAddress address, parse_listen_address(options.listen));
  if (options.workers == 0) options.workers = std::max(1U, std::thread::hardware_concurrency());
  if (options.memory == 0) options.memory = available_memory() / 4 * 3;
  ASSIGN_OR_RETURN(auto access, AccessControl::open(access_options(options)));
  std::unique_ptr<ServiceMetrics> metrics;
  if (!options.metrics_listen.empty()) {
    metrics = std::make_unique<ServiceMetrics>();
    observers.add(metrics->observer());
  }
  std::shared_ptr<CertificateReloader> certificates;
  if (!options.tls_cert.empty()) {
    ASSIGN_OR_RETURN(certificates,
                     CertificateReloader::start({options.tls_cert, options.tls_key, options.tls_client_ca}));
  }
  auto server = std::make_unique<GrpcServer>(options, std::move(access), std::move(certificates), make_backend,
                                             std::move(observers));
  if (!options.health_listen.empty()) {
    ASSIGN_OR_RETURN(const ListenAddress probes, parse_listen_address(options.health_listen));
    RETURN_IF_ERROR(server->listen_for_probes(probes));
  }
  if (metrics) {
    ASSIGN_OR_RETURN(const ListenAddress scraped, parse_listen_address(options.metrics_listen));
    RETURN_IF_ERROR(server->serve_metrics(scraped, std::move(metrics)));
  }
  if (!options.http.empty()) {
    ASSIGN_OR_RETURN(const ListenAddress web, parse_listen_address(options.http));
    RETURN_IF_ERROR(server->serve_http(web));
  }
  RETURN_IF_ERROR(server->listen(address));
  return server;
}

absl::Status Server::check_access_files(const ServerOptions& options) {
  return AccessControl::open(access_options(options)).status();
}

}  // namespace segserve::server
