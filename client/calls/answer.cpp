// SPDX-License-Identifier: Apache-2.0
#include "client/calls/answer.hpp"

#include <algorithm>
#include <string_view>

#include "core/base/status_text.hpp"
#include "fmt/format.h"
#include "proto/wire/result_message.hpp"
#include "segserve/codec/decode_limits.hpp"

namespace segserve::client {

absl::StatusOr<wire::Result> decode_answer(const v1::SegmentationResult& message, std::optional<std::uint64_t> points,
                                           const wire::Outputs& wanted, bool wants_tracks) {
  const auto broken = [](std::string_view why) {
    return absl::InternalError(fmt::format("the answer is broken: {}", why));
  };
  const std::uint64_t expected = points.value_or(message.summary().points());
  if (const std::uint64_t allowed = codec::DecodeLimits{}.max_points; !points && expected > allowed) {
    return broken(fmt::format("it claims {} points, and at most {} are accepted", expected, allowed));
  }
  auto result = wire::from_message(message, expected);
  if (!result.ok()) return broken(message_of(result.status()));

  const Segmentation& got = result->segmentation;
  const bool complete = (!wanted.labels || got.labels.size() == result->points) &&
                        (!wanted.supervoxels || got.supervoxels.size() == result->points) &&
                        (!wanted.tree || got.tree.leaf_count() == result->supervoxels) &&
                        (!wanted.segments || got.statistics.size() == std::min(got.segments, kMostDescribedSegments));
  if (!complete) return broken("it lacks arrays that were asked for");
  if (wants_tracks && !result->tracks) {
    return absl::UnimplementedError(
        fmt::format("the server, version {}, does not follow objects over time", result->server_version));
  }
  return result;
}

}  // namespace segserve::client
