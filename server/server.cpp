#include "server/server.hpp"

#include <algorithm>
#include <thread>
#include <utility>

#include "fmt/format.h"
#include "grpcpp/ext/proto_server_reflection_plugin.h"
#include "grpcpp/grpcpp.h"
#include "grpcpp/health_check_service_interface.h"
#include "grpcpp/resource_quota.h"
#include "proto/wire/status_message.hpp"
#include "proto/wire/transport_limits.hpp"
#include "server/options/listen_address.hpp"
#include "server/rpc/segmentation_service.hpp"
#include "spdlog/spdlog.h"

namespace segserve::server {
namespace {

// Backstops of the transport: a unary request is in memory before we see it.
constexpr int kMaxStreamsPerConnection = 128;
constexpr std::size_t kTransportMemoryBytes = std::size_t{1} << 30U;
// For open health watches, which nothing else ends.
constexpr std::chrono::milliseconds kCloseTime{100};

template <typename Value>
void check_range(const char* flag, Value value, Value minimum, Value maximum, std::vector<FieldViolation>& faults) {
  if (value < minimum || value > maximum) {
    faults.push_back({flag, fmt::format("{} is not in [{}, {}]", value, minimum, maximum)});
  }
}

class GrpcServer final : public Server {
 public:
  GrpcServer(const ServerOptions& options, const BackendFactory& make_backend)
      : grace_period_(options.grace_period), drain_delay_(options.drain_delay), service_(options, make_backend) {}
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
  SegmentationService service_;
  std::unique_ptr<grpc::Server> server_;  // ends before the service it calls
  std::string address_;
  int port_ = 0;
};

absl::Status GrpcServer::listen(const ListenAddress& address) {
  grpc::EnableDefaultHealthCheckService(true);
  grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  grpc::ResourceQuota quota("segserve");
  quota.Resize(kTransportMemoryBytes);
  const std::string wanted = address.is_unix ? with_port(address, 0) : with_port(address, std::stoi(address.port));

  grpc::ServerBuilder builder;
  builder.SetResourceQuota(quota);
  builder.SetMaxReceiveMessageSize(wire::kServerReceiveBytes);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, kMaxStreamsPerConnection);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_BDP_PROBE, 0);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_STREAM_LOOKAHEAD_BYTES, wire::kFlowControlBytes);
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);  // else two servers share a port without a word
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
  if (!all_finished) spdlog::warn("the grace period is over: cancelling {} calls", service_.calls_in_flight());
  std::this_thread::sleep_until(std::min(deadline, begin + drain_delay_));
  server_->Shutdown(std::chrono::system_clock::now() + kCloseTime);
  server_->Wait();
  service_.wait_until_idle();
  server_.reset();
  return all_finished;
}

}  // namespace

std::vector<FieldViolation> violations(const ServerOptions& options) {
  std::vector<FieldViolation> faults;
  if (const absl::StatusOr<ListenAddress> address = parse_listen_address(options.listen); !address.ok()) {
    faults.push_back({"listen", std::string(address.status().message())});
  } else if (!address->is_loopback() && !options.insecure_beyond_loopback) {
    faults.push_back({"listen", fmt::format("{} can be reached by other machines, and the connection is not encrypted; "
                                            "--insecure-beyond-loopback allows that",
                                            options.listen)});
  }
  check_range<std::size_t>("workers", options.workers, 0, 1024, faults);
  check_range<std::uint32_t>("threads", options.threads, 1, 64, faults);
  check_range<std::size_t>("queue", options.queue, 1, 100'000, faults);
  check_range<std::uint64_t>("queue-bytes", options.queue_bytes,
                             std::max(options.max_decoded_bytes, wire::kMaxRequestBytes), std::uint64_t{1} << 50U,
                             faults);
  check_range<std::uint64_t>("queue-points", options.queue_points, options.max_points, std::uint64_t{1} << 50U, faults);
  check_range<std::uint32_t>("stream-frames", options.stream_frames, 1, 1024, faults);
  check_range<std::uint64_t>("stream-bytes", options.stream_bytes, 1, std::uint64_t{1} << 40U, faults);
  check_range<std::uint64_t>("all-streams-bytes", options.all_streams_bytes, 1, std::uint64_t{1} << 50U, faults);
  check_range<std::uint64_t>("max-points", options.max_points, 1, 1'000'000'000, faults);
  check_range<std::uint64_t>("max-decoded-bytes", options.max_decoded_bytes, 1, std::uint64_t{1} << 40U, faults);
  check_range<std::int64_t>("grace-period", options.grace_period.count(), 0, 86'400'000, faults);
  check_range<std::int64_t>("drain-delay", options.drain_delay.count(), 0, 86'400'000, faults);
  for (FieldViolation& fault : segserve::violations(options.defaults)) faults.push_back(std::move(fault));
  return faults;
}

absl::StatusOr<std::unique_ptr<Server>> Server::start(ServerOptions options, const BackendFactory& make_backend) {
  if (const absl::Status status = wire::invalid_fields(violations(options)); !status.ok()) return status;
  const absl::StatusOr<ListenAddress> address = parse_listen_address(options.listen);
  if (!address.ok()) return address.status();
  if (options.workers == 0) options.workers = std::max(1U, std::thread::hardware_concurrency());
  auto server = std::make_unique<GrpcServer>(options, make_backend);
  if (const absl::Status status = server->listen(*address); !status.ok()) return status;
  return server;
}

}  // namespace segserve::server
