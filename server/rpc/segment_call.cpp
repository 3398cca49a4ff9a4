// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/segment_call.hpp"

#include <string>
#include <utility>
#include <variant>

#include "absl/strings/escaping.h"
#include "core/base/status_macros.hpp"
#include "proto/wire/message_shape.hpp"
#include "proto/wire/status_message.hpp"
#include "proto/wire/transport_limits.hpp"
#include "server/frames/catch_exceptions.hpp"
#include "server/frames/final_status.hpp"
#include "server/frames/frame_computation.hpp"
#include "server/scheduling/client_address.hpp"
#include "server/scheduling/refusals.hpp"
#include "spdlog/spdlog.h"

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

/// Writes one line to the log. What callers chose is escaped, so that it cannot forge lines.
void log_call(const grpc::CallbackServerContext& context, const std::string& request_id,
              const v1::ResultSummary& summary, const absl::Status& status) {
  if (!spdlog::should_log(spdlog::level::debug)) return;
  const std::string id = absl::CHexEscape(request_id.substr(0, 64));
  if (status.ok()) {
    spdlog::debug("Segment from {}, id '{}': OK, {} points, {} segments, queue {:.1f} ms, total {:.1f} ms",
                  context.peer(), id, summary.points(), summary.segments(), summary.timings().queue_ms(),
                  summary.timings().total_ms());
  } else {
    spdlog::debug("Segment from {}, id '{}': {}", context.peer(), id,
                  absl::CHexEscape(status.ToString(absl::StatusToStringMode::kWithNoExtraData)));
  }
}

}  // namespace

SegmentCall::SegmentCall(SegmentationService& service, grpc::CallbackServerContext& context, grpc::ByteBuffer& response)
    : service_(service),
      context_(context),
      canceler_(context),
      memory_(service.ledger_, MemoryOwner{client_address(context.peer()), context.peer()}, service.max_voxels_),
      response_(response),
      arrival_(Clock::now()),
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
  const std::uint64_t bytes = request.Length();
  RETURN_IF_ERROR(memory_.receive(bytes));
  RETURN_IF_ERROR(parse(request));
  ASSIGN_OR_RETURN(FrameSettings settings, service_.resolver_.resolve_call(request_, arrival_, deadline_));

  // All calls on one connection count as one client's: many programs share an address, and names can be made up.
  JobInfo info{.client = context_.peer(), .points = settings.estimated_points, .bytes = bytes};
  Job job{.run = [this, settings](std::size_t worker) { run(worker, settings); },
          .evicted =
              [this] {
                finish(catch_exceptions("tell why the call ends",
                                        [&] { return evicted_from_queue(service_.pool_.retry_delay()); }));
              }};
  const auto submitted = service_.pool_.submit(std::move(info), std::move(job));
  if (const Refusal* refusal = std::get_if<Refusal>(&submitted)) {
    return queue_full(*refusal, service_.pool_.retry_delay());
  }
  ticket_ = std::get<WorkerPool::Ticket>(submitted);
  submitted_ = true;
  return absl::OkStatus();
}

void SegmentCall::run(std::size_t worker, const FrameSettings& settings) {
  finish(catch_exceptions("process this frame", [&]() -> absl::Status {
    if (deadline_ &&
        Clock::now() + service_.pool_.expected_time(context_.peer(), settings.estimated_points) > *deadline_) {
      return absl::DeadlineExceededError("the call waited for a worker until too little time was left to compute it");
    }
    ASSIGN_OR_RETURN(v1::SegmentationResult result,
                     compute_frame(request_.cloud(), settings, cancelled_, *service_.backends_[worker], memory_));
    request_.clear_cloud();  // whose lease has ended
    return answer(std::move(result));
  }));
}

absl::Status SegmentCall::answer(v1::SegmentationResult result) {
  summary_ = result.summary();
  v1::SegmentResponse response;
  response.set_request_id(request_.request_id());
  response.set_frame_id(request_.frame_id());
  if (request_.has_stamp()) *response.mutable_stamp() = request_.stamp();
  *response.mutable_result() = std::move(result);
  bool owns_buffer = false;
  const grpc::Status status =
      grpc::SerializationTraits<v1::SegmentResponse>::Serialize(response, &response_, &owns_buffer);
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

void SegmentCall::finish(const absl::Status& status) {
  const absl::Status told = catch_exceptions("tell why the call ends", [&] {
    absl::Status final = aborted_ && !status.ok() ? draining() : status;
    log_call(context_, request_.request_id(), summary_, final);
    return final;
  });
  finished_at_ = Clock::now();
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
