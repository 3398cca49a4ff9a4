// SPDX-License-Identifier: Apache-2.0
#include "server/stream/pool_frame_executor.hpp"

#include <variant>

#include "server/scheduling/refusals.hpp"

namespace segserve::server {

absl::StatusOr<FrameExecutor::Ticket> PoolFrameExecutor::submit(FrameJob job) {
  JobInfo info{.client = client_,
               .flow = stream_,
               .priority = job.priority,
               .points = job.points,
               .bytes = job.bytes,
               .may_exceed_bounds = job.may_exceed_queue};
  // The job does not keep `this`, because a worker may just have taken it when the stream ends. It is never evicted,
  // because the stream's own policy says which frames it may lose.
  Job pool_job{
      .run = [&backends = backends_, run = std::move(job.run)](std::size_t worker) { run(*backends[worker]); }};
  const auto submitted = pool_.submit(std::move(info), std::move(pool_job));
  if (const auto* refusal = std::get_if<Refusal>(&submitted)) return queue_full(*refusal, pool_.retry_delay());
  return std::get<WorkerPool::Ticket>(submitted);
}

}  // namespace segserve::server
