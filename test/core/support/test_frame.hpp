// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/executor.hpp"
#include "core/base/frame_context.hpp"

namespace segserve::test {

/// A frame as the pipeline would make it, for tests of single stages. The memory of the cloud must outlive it.
class TestFrame {
 public:
  explicit TestFrame(const CloudView& cloud, const Options& options = {}, const StopToken& stop = {})
      : executor_(options.threads), context_(cloud, options, executor_, stop) {}
  TestFrame(const TestFrame&) = delete;
  TestFrame& operator=(const TestFrame&) = delete;
  ~TestFrame() = default;

  operator const FrameContext&() const { return context_; }  // NOLINT(google-explicit-constructor)

 private:
  Executor executor_;
  FrameContext context_;
};

}  // namespace segserve::test
