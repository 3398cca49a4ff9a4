#include "segserve/client/client.hpp"

#include <utility>

#include "fmt/format.h"
#include "grpc/health/v1/health.grpc.pb.h"
#include "grpcpp/client_context.h"
#include "grpcpp/create_channel.h"
#include "grpcpp/security/credentials.h"
#include "grpcpp/support/channel_arguments.h"
#include "segserve/client/call_status.hpp"
#include "segserve/client/request.hpp"
#include "segserve/v1alpha1/segmentation_service.grpc.pb.h"
#include "segserve/wire/limits.hpp"

namespace segserve::client {
namespace {

using Service = v1alpha1::SegmentationService;
using Health = grpc::health::v1::Health;
using HealthRequest = grpc::health::v1::HealthCheckRequest;
using HealthResponse = grpc::health::v1::HealthCheckResponse;

void prepare(grpc::ClientContext& context, const ClientOptions& options,
             std::optional<std::chrono::milliseconds> timeout) {
  context.set_deadline(std::chrono::system_clock::now() + timeout.value_or(options.timeout));
  context.set_wait_for_ready(options.wait_for_server);
}

/// For a PCD file the server has counted the points.
std::size_t claimed_points(const v1alpha1::SegmentResponse& response) { return response.result().summary().points(); }

/// A bad answer is the server's fault, not the caller's.
absl::StatusOr<Result> check_answer(absl::StatusOr<Result> result, const wire::Outputs& wanted) {
  if (!result.ok())
    return absl::InternalError(fmt::format("the answer is broken: {}", std::string(result.status().message())));
  const Segmentation& got = result->segmentation;
  const bool complete = (!wanted.labels || got.labels.size() == result->points) &&
                        (!wanted.supervoxels || got.supervoxels.size() == result->points) &&
                        (!wanted.tree || got.tree.leaf_count() == result->supervoxels);
  if (!complete) return absl::InternalError("the answer is broken: it lacks arrays that were asked for");
  return result;
}

}  // namespace

absl::StatusOr<Client> Client::connect(ClientOptions options) {
  if (options.address.empty()) return absl::InvalidArgumentError("the server's address is empty");
  if (options.timeout <= std::chrono::milliseconds::zero()) {
    return absl::InvalidArgumentError(fmt::format("timeout: {} ms is not above 0", options.timeout.count()));
  }
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(wire::kClientReceiveBytes);
  auto channel = grpc::CreateCustomChannel(options.address, grpc::InsecureChannelCredentials(), arguments);
  return Client(std::move(channel), std::move(options));
}

Client::Client(std::shared_ptr<grpc::Channel> channel, ClientOptions options)
    : channel_(std::move(channel)), options_(std::move(options)) {}

absl::StatusOr<Result> Client::segment(const CloudView& cloud, const Options& options, const CallOptions& call) const {
  const auto request = planar_request(cloud, options, call);
  if (!request.ok()) return request.status();
  return call_segment(*request, call, cloud.size());
}

absl::StatusOr<Result> Client::segment_pcd_file(std::string file_bytes, std::optional<View> view,
                                                const Options& options, const CallOptions& call) const {
  const auto request = pcd_request(std::move(file_bytes), view, options, call);
  if (!request.ok()) return request.status();
  return call_segment(*request, call, std::nullopt);
}

absl::StatusOr<Result> Client::call_segment(const v1alpha1::SegmentRequest& request, const CallOptions& call,
                                            std::optional<std::size_t> points) const {
  grpc::ClientContext context;
  prepare(context, options_, call.timeout);
  v1alpha1::SegmentResponse response;
  const grpc::Status status = Service::Stub(channel_).Segment(&context, request, &response);
  if (!status.ok()) return call_status(status, options_.address);
  const std::size_t expected = points.value_or(claimed_points(response));
  return check_answer(wire::from_message(response.result(), expected), call.outputs);
}

absl::StatusOr<ServerInfo> Client::server_info(std::optional<std::chrono::milliseconds> timeout) const {
  grpc::ClientContext context;
  prepare(context, options_, timeout);
  ServerInfo info;
  const grpc::Status status = Service::Stub(channel_).GetServerInfo(&context, {}, &info);
  if (!status.ok()) return call_status(status, options_.address);
  return info;
}

absl::Status Client::health(std::optional<std::chrono::milliseconds> timeout) const {
  grpc::ClientContext context;
  prepare(context, options_, timeout);
  HealthResponse response;
  const grpc::Status status = Health::Stub(channel_).Check(&context, HealthRequest(), &response);
  if (!status.ok()) return call_status(status, options_.address);
  if (response.status() == HealthResponse::SERVING) return absl::OkStatus();
  return absl::UnavailableError(
      fmt::format("{} is {}", options_.address, HealthResponse::ServingStatus_Name(response.status())));
}

}  // namespace segserve::client
