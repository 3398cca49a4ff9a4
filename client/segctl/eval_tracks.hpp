// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/segctl/track_flags.hpp"
#include "core/lab/eval/degrade.hpp"
#include "core/lab/eval/track_scores.hpp"
#include "segserve/codec/read_options.hpp"
#include "segserve/options.hpp"

namespace segserve::segctl {

/// The arguments of `segctl eval --track`.
struct TrackEvaluation {
  std::string folder;  ///< of a sequence, or of folders of sequences
  const TrackFlags* flags = nullptr;
  Options options;
  eval::Degradation degradation;
  codec::ReadOptions read;
};

struct SequenceScores {
  std::string name;
  eval::TrackScores scores;
  double cut_deta = 0;                  ///< DetA of the segments of the cut, without tracking
  double segment_ms = 0, track_ms = 0;  ///< mean time of a frame, on one thread
  double slowest_track_ms = 0;
  std::size_t state_bytes = 0;  ///< of the largest state
};

struct TrackReport {
  std::string folder;
  std::vector<SequenceScores> sequences;
};

/// Segments and follows the sequences one after the other. Stops at the first frame that fails, whose message begins
/// with its path.
absl::StatusOr<TrackReport> score_tracks(const TrackEvaluation& evaluation);

std::string to_json(const TrackReport& report);
std::string to_text(const TrackReport& report);

}  // namespace segserve::segctl
