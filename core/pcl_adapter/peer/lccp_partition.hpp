// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "core/lab/eval/evaluation.hpp"
#include "core/pcl_adapter/peer/pcl_peer.hpp"
#include "segserve/cloud.hpp"

namespace segserve::pcl_peer {

/// How PCL segments. The defaults are those by which it is compared (core/lab/eval/README.md).
struct PeerSettings {
  VccsSettings vccs;
  LccpSettings lccp;
  bool only_supervoxels = false;  ///< Whether supervoxels are left as they are, so that each is a segment.
};

/// Segments a cloud by PCL's VCCS and LCCP. Every point has the label of the nearest voxel; 0 where PCL left it out.
/// The time does not count the copy of the points. Exceptions of PCL become RESOURCE_EXHAUSTED or INTERNAL.
absl::StatusOr<eval::Partition> partition(const CloudView& cloud, const PeerSettings& settings);

}  // namespace segserve::pcl_peer
