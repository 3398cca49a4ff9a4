// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <thread>
#include <utility>

#include "server/frames/segmentation_backend.hpp"

namespace segserve::server {

/// Shared by all backends of a blocking fake: every segmentation waits until it is released or told to stop.
class Blockade {
 public:
  absl::StatusOr<Segmentation> pass(const CloudView& cloud, const StopToken& stop) {
    ++entered_;
    while (!released_ && !stop.stopped()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    if (const absl::Status status = stop.check(); !status.ok()) {
      ++stopped_;
      return status;
    }
    Segmentation result;
    result.labels.assign(cloud.size(), 0);
    result.supervoxels.assign(cloud.size(), 0);
    return result;
  }
  void release() { released_ = true; }

  int entered() const { return entered_; }  ///< calls that reached the segmentation
  int stopped() const { return stopped_; }  ///< calls among these that their StopToken ended

 private:
  std::atomic<bool> released_{false};
  std::atomic<int> entered_{0}, stopped_{0};
};

/// A backend made of a function.
class FakeBackend final : public SegmentationBackend {
 public:
  using Function = std::function<absl::StatusOr<Segmentation>(const CloudView&, const Options&, const StopToken&)>;

  explicit FakeBackend(Function function) : function_(std::move(function)) {}
  absl::StatusOr<Segmentation> segment(const CloudView& cloud, const Options& options, const StopToken& stop,
                                       const Admission& /*admit*/) override {
    return function_(cloud, options, stop);
  }

 private:
  Function function_;
};

inline BackendFactory fake_factory(FakeBackend::Function function) {
  return [function] { return std::make_unique<FakeBackend>(function); };
}

inline BackendFactory blocking_factory(Blockade& blockade) {
  return fake_factory([&blockade](const CloudView& cloud, const Options&, const StopToken& stop) {
    return blockade.pass(cloud, stop);
  });
}

/// Waits until the condition is true, and returns true then; false after a time that is too long for any test.
inline bool eventually(const std::function<bool()>& condition) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (std::chrono::steady_clock::now() < deadline) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return condition();
}

}  // namespace segserve::server
