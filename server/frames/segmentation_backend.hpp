// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>

#include "absl/status/statusor.h"
#include "segserve/segment.hpp"

namespace segserve::server {

/// The part of core that the service needs; a test can put something else in its place. Every worker has an object of
/// its own, which only that worker's thread uses.
class SegmentationBackend {
 public:
  virtual ~SegmentationBackend() = default;

  /// See segserve::Segmenter::segment. May throw.
  virtual absl::StatusOr<Segmentation> segment(const CloudView& cloud, const Options& options, const StopToken& stop,
                                               const Admission& admit) = 0;

  /// Gives up the buffers that are kept for the next cloud.
  virtual void free_buffers() {}
};

using BackendFactory = std::function<std::unique_ptr<SegmentationBackend>()>;

/// Makes backends that run core's pipeline and keep its buffers from frame to frame.
BackendFactory core_backend_factory();

}  // namespace segserve::server
