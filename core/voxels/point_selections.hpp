// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

#include "core/voxels/point_selection.hpp"
#include "segserve/cloud.hpp"
#include "segserve/options.hpp"

namespace segserve {

/// Which points of a cloud are selected. Each of several cameras selects its own points by the distance from itself.
class PointSelections {
 public:
  /// Selects as the options say, which must be valid in this view.
  PointSelections(const Options& options, const View& view) {
    const bool by_range = options.range_min || options.range_max;
    if (!by_range || view.cameras.empty()) {
      parts_.push_back({PointSelection(options, view), std::numeric_limits<std::size_t>::max()});
      return;
    }
    std::size_t end = 0;
    for (const CameraPoints& camera : view.cameras) {
      end += camera.points;
      parts_.push_back({PointSelection(options, {ViewKind::kWorld, camera.sensor}), end});
    }
  }

  /// Points that follow one another and are selected alike.
  struct Part {
    PointSelection selection;
    std::size_t end;  ///< the first point after them
  };

  /// The part of a point of the cloud.
  const Part& at(std::size_t point) const {
    return *std::ranges::find_if(parts_, [point](const Part& part) { return point < part.end; });
  }

  /// Whether every point is selected.
  bool all() const { return parts_.front().selection.all(); }

 private:
  std::vector<Part> parts_;
};

}  // namespace segserve
