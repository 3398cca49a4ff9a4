// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/segctl/recording_flags.hpp"
#include "core/lab/synth/moving_tabletop.hpp"
#include "segserve/cloud.hpp"
#include "segserve/codec/labeled_cloud.hpp"
#include "segserve/tracking.hpp"

namespace segserve::segctl {

/// A cloud on its way into a stream.
struct FeedFrame {
  std::string name;                                   ///< for messages, such as that of its file
  double time = 0;                                    ///< seconds since the first frame, if the feed tells times
  absl::StatusOr<codec::LabeledCloud> content;        ///< or why this frame cannot be read
  std::optional<RigidTransform> pose = std::nullopt;  ///< from the frame of the cloud to that of the world
  std::string frame_id = {};
};

/// Where the frames of a stream come from, one after the other.
class FrameFeed {
 public:
  virtual ~FrameFeed() = default;
  /// The next frame; nothing at the end. An error ends the feed.
  virtual absl::StatusOr<std::optional<FeedFrame>> next() = 0;
  /// Whether frames have times of their own, as those of recordings and of sequence.json have.
  virtual bool has_times() const = 0;
};

/// The source of a feed.
struct FeedOptions {
  std::vector<std::string> inputs;             ///< files of clouds, one folder, or one recording
  RecordingFlags recording;                    ///< which topic of a recording
  std::optional<View> view;                    ///< replaces that of files
  std::optional<synth::MovingOptions> moving;  ///< a synthetic scene instead of inputs
};

/// Opens a feed at its beginning. Errors are those of the readers; INVALID_ARGUMENT for flags of a recording without
/// one, and for a recording among other inputs.
absl::StatusOr<std::unique_ptr<FrameFeed>> open_feed(const FeedOptions& options);

}  // namespace segserve::segctl
