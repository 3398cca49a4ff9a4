// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/executor.hpp"
#include "core/base/voxel_scale.hpp"
#include "segserve/cloud.hpp"
#include "segserve/options.hpp"
#include "segserve/stop_token.hpp"

namespace segserve {

/// All that a stage must know of the frame that is being segmented. The pipeline makes it once a frame and hands it to
/// every stage as the first parameter, before the inputs and then the outputs.
struct FrameContext {
  /// The options must be valid for the view of the cloud (`check`); those that are unset get the method's defaults
  /// here. The memory of the cloud and `frame_executor` must outlive the context.
  FrameContext(const CloudView& frame_cloud, const Options& requested, Executor& frame_executor,
               const StopToken& stop_token = {})
      : cloud(frame_cloud),
        options(resolved(requested)),
        settings(supervoxel_options(options)),
        scale(requested_scale(options, frame_cloud.view)),
        executor(frame_executor),
        stop(stop_token) {}

  const View& view() const { return cloud.view; }

  /// Whether a camera, several of them, or a LiDAR saw the scene, each from one place, so that things hide each other
  /// and the borders between them are seen in part. Other clouds were scanned from all around.
  bool has_hidden_parts() const {
    return view().kind == ViewKind::kCamera || scale.sweep.has_value() || !view().cameras.empty();
  }

  CloudView cloud;
  Options options;             ///< resolved: every option for which the method has a default is set
  SupervoxelOptions settings;  ///< weights of the supervoxels, from `options`
  VoxelScale scale;            ///< sizes of voxels and supervoxels; the pipeline lets the cloud choose them
  Executor& executor;
  StopToken stop;
};

}  // namespace segserve
