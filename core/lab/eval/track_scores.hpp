// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "core/lab/eval/contingency.hpp"

namespace segserve::eval {

// Scores of objects that are followed over a sequence of frames, by their points. The definitions are those of
// TrackEval; `similarity` is the intersection over union (IoU) of the points of an object and of a track in a frame.

/// Scores of a sequence.
struct TrackScores {
  /// Higher-order tracking accuracy (Luiten et al. 2021): sqrt(deta * assa), as a mean over the least similarities
  /// 0.05, 0.1 and so on up to 0.95.
  double hota = 0;
  double deta = 0;    ///< how well objects are detected, frame by frame
  double assa = 0;    ///< how well tracks stay on their objects
  double hota50 = 0;  ///< HOTA at the least similarity 0.5
  /// Identification F1 (Ristani et al. 2016) at the similarity 0.5.
  double idf1 = 0;
  /// How often an object got another track than it had before (Bernardin and Stiefelhagen 2008), at the similarity 0.5.
  std::uint64_t switches = 0;
  /// The number of id switches where the object could be seen in every frame since it had the other track.
  std::uint64_t visible_switches = 0;
  std::uint64_t frames = 0;
  std::uint64_t objects = 0;     ///< different ones
  std::uint64_t tracks = 0;      ///< different ones
  std::uint64_t detections = 0;  ///< of objects in the ground truth, summed over the frames

  double switches_per_100_frames() const {
    return frames == 0 ? 0 : 100.0 * static_cast<double>(switches) / static_cast<double>(frames);
  }
  double visible_switches_per_100_frames() const {
    return frames == 0 ? 0 : 100.0 * static_cast<double>(visible_switches) / static_cast<double>(frames);
  }
};

/// Scores a sequence. Objects are the regions with labels from kFirstObjectLabel on. A region or segment of less than
/// `least_points` is none; points of such regions count for nothing. A segment of which at least half lies on
/// the support is no detection.
class TrackScoring {
 public:
  explicit TrackScoring(std::uint64_t least_points = 100) : least_points_(least_points) {}

  /// The next frame: `regions` have the labels of objects, `segments` the ids of tracks; 0 is no track.
  void add(const Contingency& frame);
  TrackScores scores() const;

 private:
  /// Two of a frame that have points in common.
  struct Pair {
    std::size_t object = 0, track = 0;  ///< numbers over the sequence
    double similarity = 0;
  };
  struct Frame {
    std::vector<std::size_t> objects, tracks;
    std::vector<Pair> pairs;
  };

  static std::size_t number_of(std::uint32_t label, std::map<std::uint32_t, std::size_t>& numbers);
  void score_hota(TrackScores& scores) const;
  void score_identity(TrackScores& scores) const;
  void count_switches(TrackScores& scores) const;

  std::uint64_t least_points_;
  std::vector<Frame> frames_;
  std::map<std::uint32_t, std::size_t> object_numbers_, track_numbers_;
};

}  // namespace segserve::eval
