// SPDX-License-Identifier: Apache-2.0
#include "server/memory/frame_memory.hpp"

#include <algorithm>
#include <chrono>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/status_macros.hpp"
#include "fmt/format.h"
#include "proto/wire/status_message.hpp"

namespace segserve::server {
namespace {

constexpr std::uint64_t kCloudBytesPerPoint = 16;   // x, y, z, and color
constexpr std::uint64_t kResultBytesPerPoint = 16;  // labels and supervoxels, in core and encoded

absl::Status never_fits(std::string_view what, std::string_view limit, std::uint64_t allowed, std::uint64_t actual,
                        double voxel_resolution) {
  std::map<std::string, std::string> metadata = {
      {"limit", std::string(limit)}, {"allowed", fmt::format("{}", allowed)}, {"actual", fmt::format("{}", actual)}};
  std::string advice;
  if (voxel_resolution > 0) {
    metadata["voxel_resolution"] = fmt::format("{}", voxel_resolution);
    advice = fmt::format("; a voxel_resolution of {} m would fit", voxel_resolution);
  }
  return wire::with_details(
      absl::ResourceExhaustedError(fmt::format("{} {}, more than {} = {}{}", what, actual, limit, allowed, advice)),
      {.reason = wire::ErrorReason::kLimitExceeded, .metadata = std::move(metadata)});
}

absl::Status in_use_by_others() {
  constexpr std::chrono::milliseconds kRetryDelay{200};
  return wire::with_details(
      absl::ResourceExhaustedError("other frames hold the memory that this one needs; try again later"),
      {.reason = wire::ErrorReason::kQueueFull, .metadata = {{"limit", "memory_bytes"}}, .retry_delay = kRetryDelay});
}

}  // namespace

std::uint64_t FrameMemory::most_scratch_bytes(std::uint64_t points) const {
  if (ledger_ == nullptr) return std::numeric_limits<std::uint64_t>::max();
  const std::uint64_t others = payload_bytes_ + kCloudBytesPerPoint * points;
  return ledger_->budget() - std::min(ledger_->budget(), others);
}

absl::Status FrameMemory::check_budget(std::uint64_t bytes) const {
  if (bytes <= ledger_->budget()) return absl::OkStatus();
  return never_fits("the bytes of memory that the frame needs are", "memory_bytes", ledger_->budget(), bytes, 0);
}

absl::Status FrameMemory::need(std::uint64_t bytes) {
  if (ledger_ == nullptr) return absl::OkStatus();
  RETURN_IF_ERROR(check_budget(bytes));
  return lease_.resize(bytes) ? absl::OkStatus() : in_use_by_others();
}

absl::Status FrameMemory::receive(std::uint64_t bytes) {
  payload_bytes_ = bytes;
  if (ledger_ == nullptr) return absl::OkStatus();
  RETURN_IF_ERROR(check_budget(bytes));
  std::optional<MemoryLease> lease = ledger_->lease(owner_, bytes);
  if (!lease) return in_use_by_others();
  lease_ = *std::move(lease);
  return absl::OkStatus();
}

absl::Status FrameMemory::decode(std::uint64_t points, std::uint64_t scratch_bytes) {
  return need(payload_bytes_ + kCloudBytesPerPoint * points + scratch_bytes);
}

absl::Status FrameMemory::voxelize(std::uint64_t points) {
  return need(payload_bytes_ + kCloudBytesPerPoint * points + voxelization_bytes(points));
}

absl::Status FrameMemory::segment(const FrameSize& size) {
  if (ledger_ == nullptr) return absl::OkStatus();
  const auto resolution_for = [&](std::uint64_t voxels) {
    return voxels > 0 ? size.resolution_for(static_cast<std::size_t>(voxels)) : 0;
  };
  if (size.voxels > max_voxels_) {
    return never_fits("the voxels of the cloud are", "max_voxels", max_voxels_, size.voxels,
                      resolution_for(max_voxels_));
  }
  const std::uint64_t of_points = payload_bytes_ + (kCloudBytesPerPoint + kResultBytesPerPoint) * size.points;
  const std::uint64_t bytes = of_points + size.workspace_bytes;
  if (bytes > ledger_->budget()) {
    const std::uint64_t without_voxels = of_points + workspace_bytes(size.points, 0);
    const std::uint64_t bytes_per_voxel = workspace_bytes(0, 1) - workspace_bytes(0, 0);
    const std::uint64_t fitting = (ledger_->budget() - std::min(ledger_->budget(), without_voxels)) / bytes_per_voxel;
    return never_fits("the bytes of memory that the frame needs are", "memory_bytes", ledger_->budget(), bytes,
                      resolution_for(fitting));
  }
  return need(bytes);
}

void FrameMemory::keep_result(std::uint64_t bytes) {
  payload_bytes_ = 0;
  lease_.resize(std::min(bytes, lease_.bytes()), LeaseKind::kResult);
}

}  // namespace segserve::server
