// SPDX-License-Identifier: Apache-2.0
#include "client/calls/answer.hpp"

#include <algorithm>
#include <string>

#include "fmt/format.h"

namespace segserve::client {

absl::StatusOr<wire::Result> check_answer(absl::StatusOr<wire::Result> result, const wire::Outputs& wanted) {
  if (!result.ok()) {
    return absl::InternalError(fmt::format("the answer is broken: {}", std::string(result.status().message())));
  }
  const Segmentation& got = result->segmentation;
  const bool complete = (!wanted.labels || got.labels.size() == result->points) &&
                        (!wanted.supervoxels || got.supervoxels.size() == result->points) &&
                        (!wanted.tree || got.tree.leaf_count() == result->supervoxels) &&
                        (!wanted.segments || got.statistics.size() == std::min(got.segments, kMostDescribedSegments));
  if (!complete) return absl::InternalError("the answer is broken: it lacks arrays that were asked for");
  return result;
}

}  // namespace segserve::client
