// SPDX-License-Identifier: Apache-2.0
#include "segserve/client/client.hpp"

#include <cstddef>
#include <utility>

#include "client/calls/answer.hpp"
#include "client/calls/channels.hpp"
#include "client/calls/connected_channels.hpp"
#include "client/calls/local.hpp"
#include "client/calls/payload_data.hpp"
#include "client/calls/repeated_call.hpp"
#include "client/calls/request.hpp"
#include "client/stream/stream_threads.hpp"
#include "core/base/status_macros.hpp"
#include "fmt/format.h"
#include "grpc/health/v1/health.grpc.pb.h"
#include "proto/wire/status_message.hpp"
#include "proto/wire/traceparent.hpp"
#include "segserve/v1/segmentation_service.grpc.pb.h"

namespace segserve::client {
namespace {

using Service = v1::SegmentationService;
using Health = grpc::health::v1::Health;
using HealthRequest = grpc::health::v1::HealthCheckRequest;
using HealthResponse = grpc::health::v1::HealthCheckResponse;
using Timeout = std::optional<std::chrono::milliseconds>;

bool is_too_large(const absl::Status& status) {
  const wire::ErrorDetails details = wire::details_of(status);
  const auto limit = details.metadata.find("limit");
  return details.reason == wire::ErrorReason::kLimitExceeded && limit != details.metadata.end() &&
         limit->second == "max_message_bytes";
}

/// The result of a stream, or else why a unary call would not do: a server without streams has no other limits.
absl::StatusOr<Result> or_else(absl::StatusOr<Result> streamed, const absl::Status& too_large) {
  if (absl::IsUnimplemented(streamed.status())) return too_large;
  return streamed;
}

}  // namespace

/// The state that copies of a client share.
class Client::State {
 public:
  State(std::shared_ptr<Channels> channels, ClientOptions options)
      : channels_(std::move(channels)), options_(std::move(options)) {}

  const std::shared_ptr<Channels>& channels() const { return channels_; }
  const ClientOptions& options() const { return options_; }

  absl::Status call(Timeout timeout, Attempt attempt) const {
    return repeat_call(*channels_, options_, timeout.value_or(options_.timeout), attempt);
  }

  /// `points` is unset if only the server knows how many there are.
  absl::StatusOr<Result> segment(const v1::SegmentRequest& request, const CallOptions& options,
                                 std::optional<std::uint64_t> points) const {
    v1::SegmentResponse response;
    RETURN_IF_ERROR(wire::check_traceparent(options.traceparent));  // gRPC ends a process that sends other bytes
    RETURN_IF_ERROR(call(options.timeout, [&](const auto& channel, grpc::ClientContext& context) {
      if (!options.traceparent.empty()) context.AddMetadata(wire::kTraceparentKey, options.traceparent);
      return Service::Stub(channel).Segment(&context, request, &response);
    }));
    return decode_answer(response.result(), points, options.outputs, options.tracking.has_value());
  }

  bool falls_back(const absl::Status& status) const {
    return options_.fallback_to_local && absl::IsUnavailable(status);
  }

  /// Stops at the deadline of a call that began at `start`.
  StopToken until_deadline(Time start, const CallOptions& options) const {
    return StopToken(nullptr, start + options.timeout.value_or(options_.timeout));
  }

 private:
  const std::shared_ptr<Channels> channels_;
  const ClientOptions options_;
};

absl::StatusOr<Client> Client::connect(ClientOptions options) {
  ASSIGN_OR_RETURN(std::shared_ptr<Channels> channels, make_channels(options));
  return Client(std::make_shared<const State>(std::move(channels), std::move(options)));
}

Client::Client(std::shared_ptr<const State> state) : state_(std::move(state)) {}

Client::Client(std::shared_ptr<grpc::Channel> channel, const ClientOptions& options)
    : Client(std::make_shared<const State>(std::make_shared<Channels>(options.address, std::move(channel)), options)) {}

absl::StatusOr<Stream> Client::open_stream(StreamOptions options) const {
  RETURN_IF_ERROR(wire::invalid_fields(violations(options)));
  const wire::CodecOptions codec = options.codec;
  return Stream(std::make_shared<StreamThreads>(state_->channels(), std::move(options)), codec);
}

absl::StatusOr<Result> Client::segment(const CloudView& cloud, const Options& options, const CallOptions& call) const {
  const Time start = Clock::now();
  const auto request = cloud_request(cloud, options, call);
  if (request.ok()) {
    auto result = state_->segment(*request, call, cloud.size());
    if (!state_->falls_back(result.status())) return result;
    const StopToken stop = state_->until_deadline(start, call);
    return segment_here(make_payload(request->cloud(), cloud.size()), options, call.outputs, stop, call.prompts,
                        call.tracking);
  }
  if (!is_too_large(request.status())) return request.status();
  const bool compress = call.compress != Compress::kNever;
  const wire::CodecOptions planar{.codec = compress ? wire::Codec::kPlanarZstd : wire::Codec::kPlanar};
  ASSIGN_OR_RETURN(Payload payload, cloud_payload(cloud, call.codec.value_or(planar)));
  return or_else(stream_one(std::move(payload), options, call), request.status());
}

absl::StatusOr<Result> Client::segment_payload(const Payload& payload, const Options& options,
                                               const CallOptions& call) const {
  const Time start = Clock::now();
  const auto request = payload_request(payload, options, call);
  if (!request.ok()) return or_else(stream_one(payload, options, call), request.status());
  auto result = state_->segment(*request, call, std::nullopt);
  if (!state_->falls_back(result.status())) return result;
  return segment_here(payload, options, call.outputs, state_->until_deadline(start, call), call.prompts, call.tracking);
}

absl::StatusOr<Result> Client::segment_pcd_file(std::string file_bytes, std::optional<View> view,
                                                const Options& options, const CallOptions& call) const {
  return segment_payload(pcd_payload(std::move(file_bytes), view), options, call);
}

absl::StatusOr<Result> Client::stream_one(Payload payload, const Options& options, const CallOptions& call) const {
  const ClientOptions& client_options = state_->options();
  StreamOptions stream_options{.options = options, .outputs = call.outputs};
  stream_options.max_servers = 1;
  stream_options.max_in_flight = 1;
  stream_options.wanted_bytes = payload.bytes();
  stream_options.frame_timeout = call.timeout.value_or(client_options.timeout);
  stream_options.retry = client_options.retry;
  stream_options.wait_for_server = client_options.wait_for_server;
  stream_options.fallback_to_local = client_options.fallback_to_local;
  ASSIGN_OR_RETURN(Stream stream, open_stream(std::move(stream_options)));
  FrameOptions frame{.prompts = call.prompts, .request_id = call.request_id, .traceparent = call.traceparent};
  frame.tracking = call.tracking;
  RETURN_IF_ERROR(stream.send(std::move(payload), std::move(frame)).status());
  std::optional<Outcome> outcome = stream.next();
  if (outcome->kind != OutcomeKind::kResult) return outcome->status;
  return *std::move(outcome->result);
}

absl::StatusOr<ServerInfo> Client::server_info(Timeout timeout) const {
  ServerInfo info;
  RETURN_IF_ERROR(state_->call(timeout, [&](const auto& channel, grpc::ClientContext& context) {
    return Service::Stub(channel).GetServerInfo(&context, {}, &info);
  }));
  return info;
}

absl::Status Client::health(Timeout timeout, const std::string& service) const {
  HealthRequest request;
  request.set_service(service);
  HealthResponse response;
  RETURN_IF_ERROR(state_->call(timeout, [&](const auto& channel, grpc::ClientContext& context) {
    return Health::Stub(channel).Check(&context, request, &response);
  }));
  if (response.status() == HealthResponse::SERVING) return absl::OkStatus();
  return absl::UnavailableError(
      fmt::format("{} is {}", state_->options().address, HealthResponse::ServingStatus_Name(response.status())));
}

}  // namespace segserve::client
