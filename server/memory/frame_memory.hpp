// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <utility>

#include "absl/status/status.h"
#include "segserve/segment.hpp"
#include "server/memory/memory_ledger.hpp"

namespace segserve::server {

/// The memory of one frame, from its header until its client has read the result. Each step tells the ledger what it
/// needs before it allocates that. One thread at a time may use an object.
///
/// Errors are RESOURCE_EXHAUSTED. Their reason is LIMIT_EXCEEDED if the frame would never fit, with metadata that name
/// the limit and, if the voxels are the cause, a `voxel_resolution` that would fit. It is QUEUE_FULL if other frames
/// hold the memory, with a delay after which to try again.
class FrameMemory {
 public:
  /// Holds nothing, and has no ledger.
  FrameMemory() = default;
  FrameMemory(MemoryLedger& ledger, MemoryOwner owner, std::uint64_t max_voxels)
      : ledger_(&ledger), owner_(std::move(owner)), max_voxels_(max_voxels) {}

  /// A payload of so many bytes comes, and is kept until the result is there.
  absl::Status receive(std::uint64_t bytes);
  /// The payload is decoded into at most `points` points, for which its codec needs at most `scratch_bytes` more.
  absl::Status decode(std::uint64_t points, std::uint64_t scratch_bytes);
  /// The decoded cloud has so many points, of which voxels are made.
  absl::Status voxelize(std::uint64_t points);
  /// The cloud has this size (see Admission).
  absl::Status segment(const FrameSize& size);
  /// Nothing but a result of so many bytes is left.
  void keep_result(std::uint64_t bytes);

  std::uint64_t bytes() const { return lease_.bytes(); }
  /// The most that `decode` can ever lease for the codec beside so many points.
  std::uint64_t most_scratch_bytes(std::uint64_t points) const;

 private:
  absl::Status check_budget(std::uint64_t bytes) const;
  absl::Status need(std::uint64_t bytes);

  MemoryLedger* ledger_ = nullptr;
  MemoryOwner owner_;
  std::uint64_t max_voxels_ = 0;
  MemoryLease lease_;
  std::uint64_t payload_bytes_ = 0;
};

}  // namespace segserve::server
