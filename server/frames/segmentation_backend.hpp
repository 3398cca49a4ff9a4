#pragma once

#include <functional>
#include <memory>

#include "absl/status/statusor.h"
#include "segserve/segment.hpp"

namespace segserve::server {

/// What the service needs of core, so that a test can put something else in its place. One object per
/// worker; one thread at a time uses it.
class SegmentationBackend {
 public:
  virtual ~SegmentationBackend() = default;

  /// See segserve::Segmenter::segment.
  virtual absl::StatusOr<Segmentation> segment(const CloudView& cloud, const Options& options,
                                               const StopToken& stop) = 0;
};

using BackendFactory = std::function<std::unique_ptr<SegmentationBackend>()>;

/// Makes objects that run core's pipeline and keep its buffers from call to call.
BackendFactory core_backend_factory();

}  // namespace segserve::server
