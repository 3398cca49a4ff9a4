#include "segserve/server/segment_call.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "absl/strings/escaping.h"
#include "segserve/server/frame.hpp"
#include "segserve/wire/limits.hpp"
#include "segserve/wire/status.hpp"
#include "spdlog/spdlog.h"

namespace segserve::server {
namespace {

using Clock = std::chrono::steady_clock;

/// gRPC tells deadlines by the wall clock, and "none" by its greatest time.
std::optional<Clock::time_point> steady_deadline(const grpc::CallbackServerContext& context) {
  const auto deadline = context.deadline();
  if (deadline == std::chrono::system_clock::time_point::max()) return std::nullopt;
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(deadline - std::chrono::system_clock::now());
}

/// One line for the log. What callers chose is escaped, so that it cannot forge lines.
void log_call(const grpc::CallbackServerContext& context, const v1alpha1::SegmentRequest& request,
              const v1alpha1::SegmentResponse& response, const absl::Status& status) {
  if (!spdlog::should_log(spdlog::level::debug)) return;
  const std::string id = absl::CHexEscape(request.request_id().substr(0, 64));
  const v1alpha1::ResultSummary& summary = response.result().summary();
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

SegmentCall::SegmentCall(SegmentationService& service, const grpc::CallbackServerContext& context,
                         const v1alpha1::SegmentRequest& request, v1alpha1::SegmentResponse& response)
    : service_(service),
      context_(context),
      request_(request),
      response_(response),
      arrival_(Clock::now()),
      deadline_(steady_deadline(context)) {}

void SegmentCall::start() {
  if (const absl::Status status = admit(); !status.ok()) finish(status);
}

absl::Status SegmentCall::admit() {
  if (const std::uint64_t bytes = request_.ByteSizeLong(); bytes > wire::kMaxRequestBytes) {
    return wire::limit_exceeded("the request has", bytes, "bytes", "max_message_bytes", wire::kMaxRequestBytes);
  }
  absl::StatusOr<wire::ParsedRequest> parsed = wire::parse_request(request_, service_.defaults_);
  if (!parsed.ok()) return parsed.status();
  parsed->options.threads = std::min(parsed->options.threads, service_.max_threads_);

  ticket_ = service_.pool_.submit([this, parsed = *std::move(parsed)](std::size_t worker) { run(worker, parsed); });
  if (ticket_) return absl::OkStatus();
  return wire::with_details(absl::ResourceExhaustedError("all workers are busy and the queue is full; try again later"),
                            {.reason = v1alpha1::ERROR_REASON_QUEUE_FULL, .retry_delay = service_.retry_delay()});
}

void SegmentCall::run(std::size_t worker, const wire::ParsedRequest& parsed) {
  const Clock::time_point started = Clock::now();
  absl::StatusOr<v1alpha1::SegmentationResult> result =
      process({request_.cloud(), parsed, arrival_}, service_.limits_, *service_.segmenters_[worker], stop_token());
  if (result.ok()) {
    response_.set_request_id(request_.request_id());
    response_.set_frame_id(request_.frame_id());
    if (request_.has_stamp()) *response_.mutable_stamp() = request_.stamp();
    *response_.mutable_result() = *std::move(result);
    service_.note_duration(Clock::now() - started);
  }
  finish(result.status());
}

void SegmentCall::OnCancel() {
  cancelled_ = true;
  if (ticket_ && service_.pool_.withdraw(*ticket_)) {
    finish(deadline_ && Clock::now() >= *deadline_
               ? absl::DeadlineExceededError("the deadline passed while the call waited for a worker")
               : absl::CancelledError("cancelled while the call waited for a worker"));
  }
}

void SegmentCall::finish(const absl::Status& status) {
  log_call(context_, request_, response_, status);
  Finish(wire::to_grpc(status));  // from here on `this` may be gone
}

void SegmentCall::OnDone() {
  CallGate& gate = service_.gate_;
  delete this;
  gate.leave();  // last: the service may end as soon as nobody is in
}

}  // namespace segserve::server
