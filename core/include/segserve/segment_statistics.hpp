#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "core/math/vec3.hpp"
#include "segserve/cloud.hpp"
#include "segserve/stop_token.hpp"

namespace segserve {

/// A box in any position: the points center + a axes[0] + b axes[1] + c axes[2] with |a|, |b|, |c| at most
/// half_extents.x, .y, .z. Metres, in the frame of the cloud.
struct OrientedBox {
  Vec3 center;
  std::array<Vec3, 3> axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  ///< unit vectors, right-handed
  Vec3 half_extents;                                            ///< 0 along axes in which the points do not differ
  bool operator==(const OrientedBox&) const = default;
};

/// What there is to say of one segment, in the frame of the cloud.
struct SegmentStatistics {
  std::uint32_t points = 0;
  Vec3 centroid;  ///< mean of the points, metres
  /// The smallest box that holds every point and has the principal axes of the points (see principal_axes), that of
  /// the greatest variance first: not the smallest of all boxes.
  OrientedBox box;
  std::optional<Vec3> color;  ///< mean of (R, G, B), sRGB, 0..255 each; unset if the cloud has no colour
  /// Direction of the sum of the unit normals of the segment's voxels, hence a mean over the surface, however densely
  /// it was sampled; a unit vector. Unset if nobody knows the voxels' normals, or if they cancel out.
  std::optional<Vec3> normal;
  bool operator==(const SegmentStatistics&) const = default;
};

/// No more segments of a result are described, the largest: a bound on time and memory that only results of
/// thousands of fragments reach.
inline constexpr std::uint32_t kMostDescribedSegments = 10'000;

/// Statistics of segments 1 .. `segments` (entry k - 1 is segment k) of a cloud of N points from its labels (N, as
/// Segmentation::labels; larger ones are ignored). Three passes over the points. The bytes of the result depend on
/// neither the order of the points, the number of threads nor the CPU. Normals are not set: see set_normals. A segment
/// without points has a box of no extent at the origin.
/// INVALID_ARGUMENT if there are not N labels, more segments than points, or a point of a segment is not finite;
/// CANCELLED, DEADLINE_EXCEEDED.
absl::StatusOr<std::vector<SegmentStatistics>> describe_segments(const CloudView& cloud,
                                                                 std::span<const std::uint32_t> labels,
                                                                 std::uint32_t segments, unsigned threads = 1,
                                                                 const StopToken& stop = {});

/// Sets the normals from those of the supervoxels (m, see Segmentation::supervoxel_normals) of which the segments
/// consist: `segment_of_leaf` (m) as in Cut; segments without an entry in `statistics` are ignored. Useless if stopped.
void set_normals(std::span<const Vec3> supervoxel_normals, std::span<const std::uint32_t> segment_of_leaf,
                 std::span<SegmentStatistics> statistics, const StopToken& stop = {});

}  // namespace segserve
