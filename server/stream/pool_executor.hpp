#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "server/segmenter_interface.hpp"
#include "server/stream/frame_executor.hpp"
#include "server/worker_pool.hpp"

namespace segserve::server {

/// The worker pool as one stream sees it. All its frames count as those of `client`.
class PoolExecutor final : public FrameExecutor {
 public:
  /// One segmenter per worker. Both must outlive the pool's jobs.
  PoolExecutor(WorkerPool& pool, const std::vector<std::unique_ptr<SegmenterInterface>>& segmenters, std::string client)
      : pool_(pool), segmenters_(segmenters), client_(std::move(client)) {}

  absl::StatusOr<Ticket> submit(FrameJob job) override;
  bool withdraw(Ticket ticket) override { return pool_.withdraw(ticket); }

 private:
  WorkerPool& pool_;
  const std::vector<std::unique_ptr<SegmenterInterface>>& segmenters_;
  const std::string client_;
};

}  // namespace segserve::server
