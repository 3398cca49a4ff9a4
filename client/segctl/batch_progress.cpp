// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/batch_progress.hpp"

#include <utility>

namespace segserve::segctl {

void BatchProgress::record(std::size_t file, FileOutcome outcome) {
  const MutexLock lock(mutex_);
  outcomes_[file] = std::move(outcome);
  bar_->show(++recorded_, outcomes_.size());
}

void BatchProgress::record_failure(std::size_t file, absl::Status status) {
  record(file, {.state = FileOutcome::State::kFailed, .status = std::move(status)});
}

std::optional<std::size_t> BatchProgress::take_next() {
  const MutexLock lock(mutex_);
  while (stopped_.ok() && next_ < outcomes_.size()) {
    const std::size_t file = next_++;
    if (outcomes_[file].state == FileOutcome::State::kOpen) return file;
  }
  return std::nullopt;
}

void BatchProgress::stop(absl::Status why) {
  const MutexLock lock(mutex_);
  if (stopped_.ok()) stopped_ = std::move(why);
}

absl::Status BatchProgress::stopped() {
  const MutexLock lock(mutex_);
  return stopped_;
}

std::vector<FileOutcome> BatchProgress::finish() {
  const MutexLock lock(mutex_);
  bar_.reset();
  return std::move(outcomes_);
}

}  // namespace segserve::segctl
