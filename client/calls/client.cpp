#include "segserve/client/client.hpp"

#include <random>
#include <thread>
#include <utility>
#include <vector>

#include "client/calls/answer.hpp"
#include "client/calls/call_status.hpp"
#include "client/calls/channels.hpp"
#include "client/calls/local.hpp"
#include "client/calls/request.hpp"
#include "client/calls/retry.hpp"
#include "client/stream/address_book.hpp"
#include "client/stream/stream_driver.hpp"
#include "fmt/format.h"
#include "grpc/health/v1/health.grpc.pb.h"
#include "grpcpp/client_context.h"
#include "proto/wire/status_message.hpp"
#include "proto/wire/transport_limits.hpp"
#include "segserve/v1/segmentation_service.grpc.pb.h"

namespace segserve::client {
namespace {

using Service = v1::SegmentationService;
using Health = grpc::health::v1::Health;
using HealthRequest = grpc::health::v1::HealthCheckRequest;
using HealthResponse = grpc::health::v1::HealthCheckResponse;

bool is_too_large(const absl::Status& status) {
  return wire::details_of(status).reason == v1::ERROR_REASON_LIMIT_EXCEEDED;
}

/// What came of a stream; a server without streams has the limits of a unary call only.
absl::StatusOr<Result> or_else(absl::StatusOr<Result> streamed, const absl::Status& too_large) {
  if (absl::IsUnimplemented(streamed.status())) return too_large;
  return streamed;
}

/// Of an encoded payload the server has counted the points.
std::size_t claimed_points(const v1::SegmentResponse& response) { return response.result().summary().points(); }

}  // namespace

absl::StatusOr<Client> Client::connect(ClientOptions options) {
  auto addresses = parse_addresses(options.address);
  if (!addresses.ok()) return addresses.status();
  if (options.timeout <= std::chrono::milliseconds::zero()) {
    return absl::InvalidArgumentError(fmt::format("timeout: {} ms is not above 0", options.timeout.count()));
  }
  return Client(std::make_shared<Channels>(*std::move(addresses)), std::move(options));
}

Client::Client(std::shared_ptr<Channels> channels, ClientOptions options)
    : channels_(std::move(channels)), options_(std::move(options)) {}

Client::Client(std::shared_ptr<grpc::Channel> channel, const ClientOptions& options)
    : Client(std::make_shared<Channels>(options.address, std::move(channel)), options) {}

absl::Status Client::call(std::optional<std::chrono::milliseconds> timeout, Attempt attempt) const {
  const Time deadline = Clock::now() + timeout.value_or(options_.timeout);
  const std::vector<std::string>& addresses = channels_->addresses();
  AddressBook book(addresses.size(), channels_->next_start(), options_.retry, std::random_device()());
  absl::Status status;
  for (std::uint32_t tries = 0; tries == 0 || is_worth_another(status, tries, book); ++tries) {
    const AddressBook::Choice choice = book.choose(Clock::now());
    if (choice.not_before >= deadline) break;
    std::this_thread::sleep_until(choice.not_before);
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + (deadline - Clock::now()));
    context.set_wait_for_ready(options_.wait_for_server && addresses.size() == 1);
    const grpc::Status answer = attempt(channels_->get(choice.address), context);
    if (answer.ok()) return absl::OkStatus();
    status = as_seen_by_a_caller_who_did_not_cancel(call_status(answer, addresses[choice.address]));
    book.failed(choice.address, Clock::now(), wire::details_of(status).retry_delay);
  }
  return status;
}

bool Client::is_worth_another(const absl::Status& status, std::uint32_t tries, const AddressBook& book) const {
  if (!is_retryable(status)) return false;
  const bool server_said_so = wire::details_of(status).reason != v1::ERROR_REASON_UNSPECIFIED;
  if (server_said_so) return tries < options_.retry.max_attempts;
  return options_.wait_for_server || !book.nobody_in_reach();
}

absl::StatusOr<Stream> Client::open_stream(StreamOptions options) const {
  if (absl::Status status = wire::invalid_fields(violations(options)); !status.ok()) return status;
  const wire::CodecOptions codec = options.codec;
  return Stream(std::make_shared<StreamDriver>(channels_, std::move(options)), codec);
}

absl::StatusOr<Result> Client::segment(const CloudView& cloud, const Options& options, const CallOptions& call) const {
  const Time start = Clock::now();
  const auto request = cloud_request(cloud, options, call);
  if (request.ok()) {
    auto result = call_segment(*request, call, cloud.size());
    if (!is_local_turn(result.status())) return result;
    return segment_here(Payload(request->cloud(), cloud.size()), options, call.outputs, until_deadline(start, call));
  }
  if (!is_too_large(request.status())) return request.status();
  const bool compress = call.compress != Compress::kNever;
  const wire::CodecOptions planar{.codec = compress ? wire::Codec::kPlanarZstd : wire::Codec::kPlanar};
  auto payload = cloud_payload(cloud, call.codec.value_or(planar));
  if (!payload.ok()) return payload.status();
  return or_else(stream_one(*std::move(payload), options, call), request.status());
}

absl::StatusOr<Result> Client::segment_payload(const Payload& payload, const Options& options,
                                               const CallOptions& call) const {
  const Time start = Clock::now();
  const auto request = payload_request(payload, options, call);
  if (!request.ok()) return or_else(stream_one(payload, options, call), request.status());
  auto result = call_segment(*request, call, std::nullopt);
  if (!is_local_turn(result.status())) return result;
  return segment_here(payload, options, call.outputs, until_deadline(start, call));
}

StopToken Client::until_deadline(std::chrono::steady_clock::time_point start, const CallOptions& call) const {
  return StopToken(nullptr, start + call.timeout.value_or(options_.timeout));
}

bool Client::is_local_turn(const absl::Status& status) const {
  return options_.fallback_to_local && absl::IsUnavailable(status);
}

absl::StatusOr<Result> Client::segment_pcd_file(std::string file_bytes, std::optional<View> view,
                                                const Options& options, const CallOptions& call) const {
  return segment_payload(pcd_payload(std::move(file_bytes), view), options, call);
}

absl::StatusOr<Result> Client::call_segment(const v1::SegmentRequest& request, const CallOptions& call,
                                            std::optional<std::size_t> points) const {
  v1::SegmentResponse response;
  const absl::Status status = this->call(call.timeout, [&](const auto& channel, grpc::ClientContext& context) {
    return Service::Stub(channel).Segment(&context, request, &response);
  });
  if (!status.ok()) return status;
  const std::size_t expected = points.value_or(claimed_points(response));
  return check_answer(wire::from_message(response.result(), expected), call.outputs);
}

absl::StatusOr<Result> Client::stream_one(Payload payload, const Options& options, const CallOptions& call) const {
  StreamOptions stream_options{.options = options, .outputs = call.outputs};
  stream_options.max_in_flight = 1;
  stream_options.wanted_bytes = payload.bytes();
  stream_options.frame_timeout = call.timeout.value_or(options_.timeout);
  stream_options.retry = options_.retry;
  stream_options.wait_for_server = options_.wait_for_server;
  stream_options.fallback_to_local = options_.fallback_to_local;
  auto stream = open_stream(std::move(stream_options));
  if (!stream.ok()) return stream.status();
  const auto sequence = stream->send(std::move(payload), {.request_id = call.request_id});
  if (!sequence.ok()) return sequence.status();
  std::optional<Outcome> outcome = stream->next();
  if (outcome->kind != OutcomeKind::kResult) return outcome->status;
  return *std::move(outcome->result);
}

absl::StatusOr<ServerInfo> Client::server_info(std::optional<std::chrono::milliseconds> timeout) const {
  ServerInfo info;
  const absl::Status status = call(timeout, [&](const auto& channel, grpc::ClientContext& context) {
    return Service::Stub(channel).GetServerInfo(&context, {}, &info);
  });
  if (!status.ok()) return status;
  return info;
}

absl::Status Client::health(std::optional<std::chrono::milliseconds> timeout) const {
  HealthResponse response;
  absl::Status status = call(timeout, [&](const auto& channel, grpc::ClientContext& context) {
    return Health::Stub(channel).Check(&context, HealthRequest(), &response);
  });
  if (!status.ok()) return status;
  if (response.status() == HealthResponse::SERVING) return absl::OkStatus();
  return absl::UnavailableError(
      fmt::format("{} is {}", options_.address, HealthResponse::ServingStatus_Name(response.status())));
}

}  // namespace segserve::client
