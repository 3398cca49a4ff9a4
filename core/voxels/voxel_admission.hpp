// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "core/base/mutex.hpp"

namespace segserve {

/// Asks whether a frame may go on while its voxels are being counted: each time that their number has doubled, from
/// kFirst on. So a cloud of many voxels is refused before it has taken much memory. Thread-safe.
class VoxelAdmission {
 public:
  static constexpr std::size_t kFirst = std::size_t{1} << 14U;
  /// Threads report their voxels in portions of about this size.
  static constexpr std::size_t kPortion = 2048;

  /// `ask` gets the number of voxels so far. One thread at a time calls it.
  using Ask = std::function<absl::Status(std::size_t voxels)>;
  explicit VoxelAdmission(Ask ask) : ask_(std::move(ask)) {}

  /// A thread has found so many more voxels. Returns false if it shall stop.
  bool add(std::size_t voxels) {
    const MutexLock lock(mutex_);
    voxels_ += voxels;
    while (status_.ok() && voxels_ >= next_) {
      status_ = ask_(voxels_);
      next_ = 2 * voxels_;
    }
    return status_.ok();
  }
  /// The refusal, or OK.
  absl::Status status() const {
    const MutexLock lock(mutex_);
    return status_;
  }

 private:
  const Ask ask_;
  mutable Mutex mutex_;
  std::size_t voxels_ ABSL_GUARDED_BY(mutex_) = 0;
  std::size_t next_ ABSL_GUARDED_BY(mutex_) = kFirst;
  absl::Status status_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace segserve
