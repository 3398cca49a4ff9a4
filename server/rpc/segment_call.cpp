// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/segment_call.hpp"

#include <string>
#include <utility>
#include <variant>

#include "core/base/status_macros.hpp"
#include "proto/wire/codec_message.hpp"
#include "proto/wire/message_shape.hpp"
#include "proto/wire/status_message.hpp"
#include "proto/wire/transport_limits.hpp"
#include "server/frames/catch_exceptions.hpp"
#include "server/frames/final_status.hpp"
#include "server/frames/frame_computation.hpp"
#include "server/rpc/caller_of.hpp"
#include "server/scheduling/refusals.hpp"

namespace segserve::server {
namespace {

using Clock = std::chrono::steady_clock;

/// gRPC gives deadlines by the wall clock; its greatest time means that there is none.
std::optional<Clock::time_point> steady_deadline(const grpc::CallbackServerContext& context) {
  const auto deadline = context.deadline();
  constexpr std::chrono::hours kForEver{24 * 365};
  if (deadline > std::chrono::system_clock::now() + kForEver) return std::nullopt;  // a sum with it could overflow
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(deadline - std::chrono::system_clock::now());
}

}  // namespace

SegmentCall::SegmentCall(SegmentationService& service, AccessGrant grant, grpc::CallbackServerContext& context,
                         grpc::ByteBuffer& response)
    : service_(service),
      context_(context),
      canceler_(context),
      grant_(std::move(grant)),
      share_(share_of(grant_.subject(), context.peer(), context.peer())),
      memory_(service.ledger_, share_.owner, service.max_voxels_),
      response_(response),
      record_(arriving_call(caller_of(context, grant_.subject()), Clock::now())),
      deadline_(steady_deadline(context)) {}

void SegmentCall::start(grpc::ByteBuffer& request) {
  self_ = shared_from_this();
  const absl::Status status = catch_exceptions("process this frame", [&] { return admit(request); });
  if (!status.ok()) finish(status);
}

absl::Status SegmentCall::parse(grpc::ByteBuffer& request) {
  const std::uint64_t bytes = request.Length();
  if (bytes > wire::kMaxRequestBytes) {
    return wire::limit_exceeded("the request has", bytes, "bytes", "max_message_bytes", wire::kMaxRequestBytes);
  }
  return wire::parse_bounded(request, "SegmentRequest", request_);
}

absl::Status SegmentCall::admit(grpc::ByteBuffer& request) {
  const std::uint64_t bytes = record_.received_bytes = request.Length();
  RETURN_IF_ERROR(memory_.receive(bytes));
  RETURN_IF_ERROR(parse(request));
  record_.request_id = request_.request_id();
  record_.payload_kind = wire::kind_of(request_.cloud());
  ASSIGN_OR_RETURN(FrameSettings settings, service_.resolver_.resolve_call(request_, record_.arrival, deadline_));
  ASSIGN_OR_RETURN(quota_, grant_.admit(settings.estimated_points, bytes));

  JobInfo info{.client = share_.client,
               .flow = share_.flow,
               .priority = grant_.priority(0),
               .points = settings.estimated_points,
               .bytes = bytes};
  Job job{.run = [this, settings](std::size_t worker) { run(worker, settings); }, .evicted = [this] { make_way(); }};
  record_.queued = Clock::now();
  const auto submitted = service_.pool_.submit(std::move(info), std::move(job));
  if (const auto* refusal = std::get_if<Refusal>(&submitted)) {
    return queue_full(*refusal, service_.pool_.retry_delay());
  }
  ticket_ = std::get<WorkerPool::Ticket>(submitted);
  submitted_ = true;
  return absl::OkStatus();
}

void SegmentCall::run(std::size_t worker, const FrameSettings& settings) {
  finish(catch_exceptions("process this frame", [&]() -> absl::Status {
    if (deadline_ &&
        Clock::now() + service_.pool_.expected_time(share_.client, settings.estimated_points) > *deadline_) {
      return absl::DeadlineExceededError("the call waited for a worker until too little time was left to compute it");
    }
    ASSIGN_OR_RETURN(v1::SegmentationResult result, compute_frame(request_.cloud(), settings, cancelled_,
                                                                  *service_.backends_[worker], memory_, record_.work));
    request_.clear_cloud();  // whose lease has ended
    quota_.settle(result.summary().points());
    return answer(std::move(result));
  }));
}

absl::Status SegmentCall::answer(v1::SegmentationResult result) {
  v1::SegmentResponse response;
  response.set_request_id(request_.request_id());
  response.set_frame_id(request_.frame_id());
  if (request_.has_stamp()) *response.mutable_stamp() = request_.stamp();
  *response.mutable_result() = std::move(result);
  bool owns_buffer = false;
  const grpc::Status status =
      grpc::SerializationTraits<v1::SegmentResponse>::Serialize(response, &response_, &owns_buffer);
  record_.sent_bytes = response_.Length();
  return status.ok() ? absl::OkStatus() : absl::InternalError("the answer cannot be serialized");
}

void SegmentCall::OnCancel() {
  cancelled_ = true;
  withdraw(catch_exceptions("tell why the call ends", [&] {
    return deadline_ && Clock::now() >= *deadline_
               ? absl::DeadlineExceededError("the deadline passed while the call waited for a worker")
               : absl::CancelledError("cancelled while the call waited for a worker");
  }));
}

void SegmentCall::abort() {
  aborted_ = true;
  cancelled_ = true;
  withdraw(catch_exceptions("tell why the call ends", draining));
}

void SegmentCall::withdraw(const absl::Status& status) {
  if (submitted_ && service_.pool_.withdraw(ticket_)) finish(status);
}

void SegmentCall::make_way() {
  record_.is_evicted = true;
  finish(catch_exceptions("tell why the call ends", [&] { return evicted_from_queue(service_.pool_.retry_delay()); }));
}

void SegmentCall::finish(const absl::Status& status) {
  const absl::Status told =
      catch_exceptions("tell why the call ends", [&] { return aborted_ && !status.ok() ? draining() : status; });
  const Time now = Clock::now();
  end_call(record_, told, now);
  if (record_.status.reason == wire::ErrorReason::kQueueFull) quota_.refund();  // the server had no room for it
  quota_ = {};
  service_.observers_.on_frame(record_);
  finished_at_ = now;
  Finish(final_status(told));  // from here on `this` may be gone
}

void SegmentCall::on_tick(Time now) {
  const Time finished_at = finished_at_;
  if (finished_at == Time::max()) return;
  if (now - finished_at >= service_.stream_settings_.result_timeout_now()) canceler_.cancel();
}

void SegmentCall::OnDone() {
  canceler_.forget();
  InFlightCalls& calls = service_.calls_;
  service_.unary_calls_.remove(self_);
  self_.reset();    // `this` may be gone now
  calls.release();  // comes last, because the service may end as soon as no call is in flight
}

}  // namespace segserve::server
