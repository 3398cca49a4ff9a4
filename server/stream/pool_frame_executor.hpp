// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "server/frames/segmentation_backend.hpp"
#include "server/scheduling/worker_pool.hpp"
#include "server/stream/frame_executor.hpp"

namespace segserve::server {

/// The worker pool as one stream sees it. All frames of the stream count as those of the flow `stream` of `client`.
class PoolFrameExecutor final : public FrameExecutor {
 public:
  /// `backends` holds one per worker. Pool and backends must outlive the pool's jobs.
  PoolFrameExecutor(WorkerPool& pool, const std::vector<std::unique_ptr<SegmentationBackend>>& backends,
                    std::string client, std::string stream)
      : pool_(pool), backends_(backends), client_(std::move(client)), stream_(std::move(stream)) {}

  absl::StatusOr<Ticket> submit(FrameJob job) override;
  bool withdraw(Ticket ticket) override { return pool_.withdraw(ticket); }
  std::chrono::nanoseconds expected_time(std::uint64_t points) const override {
    return pool_.expected_time(client_, points);
  }

 private:
  WorkerPool& pool_;
  const std::vector<std::unique_ptr<SegmentationBackend>>& backends_;
  const std::string client_, stream_;
};

}  // namespace segserve::server
