// SPDX-License-Identifier: Apache-2.0
#include "server/http/http_frame.hpp"

#include <utility>
#include <variant>

#include "core/base/status_macros.hpp"
#include "server/frames/catch_exceptions.hpp"
#include "server/scheduling/refusals.hpp"

namespace segserve::server {
namespace {

using Clock = std::chrono::steady_clock;

}  // namespace

HttpFrame::HttpFrame(SegmentationService::Parts service, AccessGrant grant, Caller caller, std::optional<Time> deadline)
    : service_(service),
      grant_(std::move(grant)),
      share_(share_of(grant_.subject(), caller.peer, caller.peer)),
      deadline_(deadline),
      memory_(service_.ledger, share_.owner, service_.max_voxels),
      record_(arriving_call(std::move(caller), Clock::now())) {}

HttpFrame::~HttpFrame() {
  if (!ended_) refuse(absl::CancelledError("the client went before its request was complete"));
  memory_ = {};              // before the service may end
  service_.calls.release();  // comes last, because the service may end as soon as no call is in flight
}

void HttpFrame::submit(Order order, std::uint64_t bytes, Done done) {
  order_ = std::move(order);
  done_ = std::move(done);
  self_ = shared_from_this();
  record_.received_bytes = bytes;
  const absl::Status status = catch_exceptions("process this frame", [&] { return queue(bytes); });
  if (!status.ok()) finish(status);
}

absl::Status HttpFrame::queue(std::uint64_t bytes) {
  const std::uint64_t points = order_.settings.estimated_points;
  ASSIGN_OR_RETURN(quota_, grant_.admit(points, bytes));
  JobInfo info{
      .client = share_.client, .flow = share_.flow, .priority = grant_.priority(0), .points = points, .bytes = bytes};
  Job job{.run = [this](std::size_t worker) { run(worker); },
          .evicted =
              [this] {
                record_.is_evicted = true;
                finish(catch_exceptions("tell why the call ends",
                                        [&] { return evicted_from_queue(service_.pool.retry_delay()); }));
              }};
  record_.queued = Clock::now();
  const auto submitted = service_.pool.submit(std::move(info), std::move(job));
  if (const auto* refusal = std::get_if<Refusal>(&submitted)) {
    return queue_full(*refusal, service_.pool.retry_delay());
  }
  ticket_ = std::get<WorkerPool::Ticket>(submitted);
  submitted_ = true;
  return absl::OkStatus();
}

void HttpFrame::run(std::size_t worker) {
  HttpAnswer answer;
  const absl::Status status = catch_exceptions("process this frame", [&]() -> absl::Status {
    const FrameSettings& settings = order_.settings;
    if (deadline_ &&
        Clock::now() + service_.pool.expected_time(share_.client, settings.estimated_points) > *deadline_) {
      return absl::DeadlineExceededError("the call waited for a worker until too little time was left to compute it");
    }
    const EncodeResult encode = [&](wire::Result& result, const CloudView& cloud) -> absl::StatusOr<std::uint64_t> {
      ASSIGN_OR_RETURN(answer, order_.encode(result, cloud));
      return answer.body.capacity();
    };
    RETURN_IF_ERROR(
        compute_frame(order_.decode, encode, settings, cancelled_, *service_.backends[worker], memory_, record_.work));
    quota_.settle(record_.work.points);
    record_.sent_bytes = answer.body.size();
    return absl::OkStatus();
  });
  order_ = {};  // the payload goes, whose lease has ended
  if (status.ok()) {
    finish(std::move(answer));
  } else {
    finish(status);
  }
}

void HttpFrame::cancel() {
  cancelled_ = true;
  withdraw(catch_exceptions("tell why the call ends",
                            [] { return absl::CancelledError("cancelled while the call waited for a worker"); }));
}

void HttpFrame::abort() {
  aborted_ = true;
  cancelled_ = true;
  withdraw(catch_exceptions("tell why the call ends", draining));
}

void HttpFrame::on_tick(Time now) {
  if (!deadline_ || now < *deadline_) return;
  withdraw(catch_exceptions("tell why the call ends", [] {
    return absl::DeadlineExceededError("the deadline passed while the call waited for a worker");
  }));
}

void HttpFrame::withdraw(const absl::Status& status) {
  if (submitted_ && service_.pool.withdraw(ticket_)) finish(status);
}

void HttpFrame::finish(absl::StatusOr<HttpAnswer> answer) {
  const absl::Status told = end(answer.status());
  const Done done = std::move(done_);
  const std::shared_ptr<HttpFrame> self = std::move(self_);
  if (told.ok()) {
    answer->owner = self;
    done(std::move(answer));
  } else {
    memory_ = {};
    done(told);
  }
}

absl::Status HttpFrame::end(const absl::Status& status) {
  absl::Status told =
      catch_exceptions("tell why the call ends", [&] { return aborted_ && !status.ok() ? draining() : status; });
  ended_ = true;
  end_call(record_, told, Clock::now());
  if (record_.status.reason == wire::ErrorReason::kQueueFull) quota_.refund();  // the server had no room for it
  quota_ = {};
  service_.observers.on_frame(record_);
  return told;
}

}  // namespace segserve::server
