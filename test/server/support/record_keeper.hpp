// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.hpp"
#include "server/observe/service_observer.hpp"

namespace segserve::server {

/// Keeps all records. Thread-safe.
class RecordKeeper final : public ServiceObserver {
 public:
  void on_frame(const FrameRecord& frame) override {
    const MutexLock lock(mutex_);
    frames_.push_back(frame);
  }
  void on_stream(const StreamRecord& stream) override {
    const MutexLock lock(mutex_);
    streams_.push_back(stream);
  }
  void on_refused_question(const RefusedQuestion& question) override {
    const MutexLock lock(mutex_);
    refused_questions_.push_back(question);
  }

  std::vector<FrameRecord> frames() const {
    const MutexLock lock(mutex_);
    return frames_;
  }
  std::vector<StreamRecord> streams() const {
    const MutexLock lock(mutex_);
    return streams_;
  }
  std::vector<RefusedQuestion> refused_questions() const {
    const MutexLock lock(mutex_);
    return refused_questions_;
  }

 private:
  mutable Mutex mutex_;
  std::vector<FrameRecord> frames_ ABSL_GUARDED_BY(mutex_);
  std::vector<StreamRecord> streams_ ABSL_GUARDED_BY(mutex_);
  std::vector<RefusedQuestion> refused_questions_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace segserve::server
