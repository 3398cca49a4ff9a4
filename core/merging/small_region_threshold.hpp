// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "segserve/options.hpp"

namespace segserve {

/// The threshold from which on no region that is too small is left in the merge tree. The tree does not depend on the
/// threshold of the request, so that it serves cuts at any threshold, unless the caller sets min_segment_points.
inline double small_region_threshold(const Options& options) {
  const double standard = default_threshold(options.method);
  return options.min_segment_points > 0 ? options.threshold.value_or(standard) : standard;
}

}  // namespace segserve
