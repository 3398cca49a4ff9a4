#pragma once

#include "absl/status/status.h"
#include "core/base/executor.hpp"
#include "segserve/cloud.hpp"
#include "segserve/options.hpp"
#include "segserve/stop_token.hpp"

namespace segserve {

/// All that a stage must know of the frame that is being segmented. The pipeline makes it once a frame, after it has
/// checked cloud and options, and hands it to every stage. What it refers to outlives the call of the stage.
struct FrameContext {
  const CloudView& cloud;
  const Options& options;             ///< resolved: whatever the method has a default for is set
  const SupervoxelOptions& settings;  ///< resolutions and weights of the supervoxels, from `options`
  Executor& executor;
  const StopToken& stop;

  const View& view() const { return cloud.view; }
};

}  // namespace segserve
