// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"
#include "segserve/merge_tree.hpp"
#include "segserve/options.hpp"
#include "segserve/rigid_transform.hpp"
#include "segserve/segment.hpp"
#include "segserve/stop_token.hpp"

// Objects that keep their ids from frame to frame. Nothing is remembered between calls: what is known of the frames
// before travels in a TrackState, and a frame with its state has one result. docs/tracking.md describes the method.
namespace segserve {

/// How objects are followed.
struct TrackOptions {
  /// From the frame of the cloud to one that is fixed to the world, such as that of a robot's base at rest. If it is
  /// unset, here or in the frame before, the motion of the view is estimated from the support plane and from what
  /// stands on it.
  std::optional<RigidTransform> pose = std::nullopt;
  /// When the cloud was captured, seconds since any moment that all frames share. It tells how far objects may have
  /// moved. If it is unset, here or in the frame before, a tenth of a second is assumed to have passed.
  std::optional<double> time = std::nullopt;
  /// The highest speed of an object relative to most of the others, m/s, [0, 100].
  double max_speed = 1.0;
  /// The number of frames for which an object that is out of sight keeps its id, [0, 1000].
  std::uint32_t keep_lost = 60;
  /// Segments of fewer points are not followed, [1, 2^31).
  std::uint32_t min_points = 100;

  bool operator==(const TrackOptions&) const = default;
};

/// All faults, with the name of each option; empty if there is none.
std::vector<FieldViolation> violations(const TrackOptions& options);

/// The knowledge about objects from the frames before; a few kilobytes. A state that was made by default knows of no
/// object.
struct TrackState {
  static constexpr std::size_t kMostTracks = 256;
  static constexpr std::size_t kMostSignatures = 24;  ///< of a track
  static constexpr std::size_t kMostBytes = std::size_t{96} * 1024;

  /// Where a supervoxel of a track was, in steps of Track::step meters from the center along the axes of the cloud, and
  /// its mean color.
  struct Signature {
    std::array<std::int16_t, 3> place{};
    std::array<std::uint8_t, 3> rgb{};
    bool operator==(const Signature&) const = default;
  };

  /// An object that is followed, as it was when it was seen last, in the frame of the last cloud.
  struct Track {
    std::uint64_t id = 0;
    std::uint32_t age = 0;                     ///< in how many frames it was seen
    std::uint16_t lost = 0;                    ///< for how many frames it has been out of sight
    std::uint16_t trust = 0;                   ///< how often the cut agreed with it, less how often it did not
    std::array<float, 3> center{};             ///< of its box, meters
    std::array<float, 6> axes{1, 0, 0, 0, 1};  ///< the first two axes of its box
    std::array<float, 3> half_extents{};       ///< of its box, around the centroids of its supervoxels, meters
    std::array<float, 3> velocity{};           ///< relative to the world, in the frame of the cloud, m/s
    float area = 0;                            ///< of the surface that was seen, square meters
    float step = 0;                            ///< see Signature, meters
    std::array<std::uint8_t, 3> rgb{};         ///< mean color
    std::vector<Signature> signatures;         ///< up to kMostSignatures of its supervoxels
    bool operator==(const Track&) const = default;
  };

  /// The plane that supports the objects: normal . p = offset.
  struct Plane {
    std::array<float, 3> normal{};
    float offset = 0;  ///< meters
    bool operator==(const Plane&) const = default;
  };

  std::uint64_t next_id = 1;  ///< of the next object that appears
  std::optional<double> time;
  std::optional<RigidTransform> pose;
  std::optional<Plane> plane;
  std::vector<Track> tracks;  ///< by ascending id

  bool operator==(const TrackState&) const = default;

  /// The state as bytes, at most kMostBytes, which have a version and a checksum. The same state has the same bytes.
  std::string bytes() const;
  /// Reads such bytes, of which none is trusted; no bytes are a state that knows nothing. INVALID_ARGUMENT says what is
  /// wrong with them.
  static absl::StatusOr<TrackState> parse(std::string_view bytes);
};

/// The events in the life of a track.
enum class TrackEventKind : std::uint8_t {
  kBorn,       ///< "born": an object appeared
  kSplit,      ///< "split": an object came off `other`, of which it was a part
  kLost,       ///< "lost": the object is out of sight
  kMerged,     ///< "merged": the object cannot be told from `other` any more, and is out of sight
  kRecovered,  ///< "recovered": the object that was out of sight is seen again
  kEnded,      ///< "ended": the object was out of sight for too long; its id will not be used again
};

/// The name of a kind of events, as in results.
std::string_view name(TrackEventKind kind);

struct TrackEvent {
  TrackEventKind kind = TrackEventKind::kBorn;
  std::uint64_t track = 0;
  std::uint64_t other = 0;  ///< of kSplit and kMerged; else 0
  bool operator==(const TrackEvent&) const = default;
};

/// A frame whose objects have ids.
struct Tracking {
  /// The segments, numbered as those of any other cut. A track that was split or merged by the cut of the segmentation
  /// keeps the node that fits it, so that each track is one segment.
  Cut cut;
  bool differs = false;                         ///< whether it is another cut than that of the segmentation
  std::vector<std::uint64_t> track_of_segment;  ///< cut.segments: the id of segment k + 1; 0 if it is not followed
  std::vector<TrackEvent> events;               ///< by ascending track
  /// The motion from the frame of the cloud before to that of this one, for what rests in the world.
  RigidTransform motion;
  TrackState state;  ///< for the next frame
};

/// Follows the objects of `previous` into a segmented cloud of this view. The result depends on nothing but the
/// arguments, and is the same bytes on every CPU. O(m T) for m supervoxels and T tracks.
///
/// The segmentation must have `supervoxel_features`, as those of Segmenter::segment have. Labels of the points are
/// those of `label_points(segmentation.supervoxels, tracking.cut)`. INVALID_ARGUMENT if an option is out of its range
/// or there are no features; CANCELLED, DEADLINE_EXCEEDED.
absl::StatusOr<Tracking> track(const Segmentation& segmentation, const View& view, const TrackState& previous,
                               const TrackOptions& options, const StopToken& stop = {});

/// Makes the cut of a tracking that of its segmentation, which gets other labels and another number of segments where
/// they differ. Statistics are removed then: `describe` sets them anew. CANCELLED, DEADLINE_EXCEEDED.
absl::Status apply(const Tracking& tracking, const StopToken& stop, Segmentation& segmentation);

}  // namespace segserve
