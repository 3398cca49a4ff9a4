// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "client/segctl/progress_bar.hpp"
#include "core/base/mutex.hpp"
#include "segserve/codec/warning.hpp"

namespace segserve::segctl {

/// The outcome of one file of a batch.
struct FileOutcome {
  enum class State { kOpen, kSkipped, kSegmented, kFailed };  ///< kOpen: the batch was stopped before it was done.
  State state = State::kOpen;
  std::size_t points = 0;                     ///< Skipped and segmented files only.
  std::uint32_t segments = 0;                 ///< Skipped and segmented files only.
  bool in_this_process = false;               ///< Whether it was segmented without a server.
  absl::Status status;                        ///< Failed files only: why.
  std::vector<codec::Warning> warnings = {};  ///< Segmented files only.
};

/// Hands out the files of a batch to several threads, collects the outcomes, and shows a progress bar.
class BatchProgress {
 public:
  explicit BatchProgress(std::size_t files) : outcomes_(files) { bar_.emplace("segment"); }

  void record(std::size_t file, FileOutcome outcome) ABSL_LOCKS_EXCLUDED(mutex_);
  void record_failure(std::size_t file, absl::Status status);

  /// The next file without an outcome. No file is handed out twice.
  std::optional<std::size_t> take_next() ABSL_LOCKS_EXCLUDED(mutex_);

  /// Hands out no more files. The first reason counts.
  void stop(absl::Status why) ABSL_LOCKS_EXCLUDED(mutex_);
  /// Why it was stopped, or OK.
  absl::Status stopped() ABSL_LOCKS_EXCLUDED(mutex_);

  /// Wipes the progress bar and returns the outcome of every file. Call it once, after all threads have ended.
  std::vector<FileOutcome> finish() ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  Mutex mutex_;
  std::optional<ProgressBar> bar_ ABSL_GUARDED_BY(mutex_);
  std::vector<FileOutcome> outcomes_ ABSL_GUARDED_BY(mutex_);
  std::size_t next_ ABSL_GUARDED_BY(mutex_) = 0;
  std::size_t recorded_ ABSL_GUARDED_BY(mutex_) = 0;
  absl::Status stopped_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace segserve::segctl
