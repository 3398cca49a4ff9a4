// SPDX-License-Identifier: Apache-2.0
#include "core/lab/eval/track_scores.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "test/core/lab/eval/random_labels.hpp"

namespace segserve::eval {
namespace {

/// `points` points of an object that a track has.
struct Run {
  std::uint32_t object, track;
  std::size_t points;
};
using Frame = std::vector<Run>;

TrackScores score(const std::vector<Frame>& frames, std::uint64_t least_points = 1) {
  TrackScoring scoring(least_points);
  for (const Frame& frame : frames) {
    Labels truth, tracks;
    for (const Run& run : frame) {
      truth.insert(truth.end(), run.points, run.object);
      tracks.insert(tracks.end(), run.points, run.track);
    }
    scoring.add(*tabulate(truth, tracks));
  }
  return scoring.scores();
}

TEST(TrackScores, OfPerfectTracksAreOne) {
  const Frame frame{{1, 9, 500}, {20, 1, 50}, {30, 2, 60}};
  const TrackScores scores = score({frame, frame, frame});
  EXPECT_DOUBLE_EQ(scores.hota, 1);
  EXPECT_DOUBLE_EQ(scores.deta, 1);
  EXPECT_DOUBLE_EQ(scores.assa, 1);
  EXPECT_DOUBLE_EQ(scores.idf1, 1);
  EXPECT_EQ(scores.switches, 0);
  EXPECT_EQ(scores.objects, 2);
  EXPECT_EQ(scores.tracks, 2);
  EXPECT_EQ(scores.detections, 6);
}

TEST(TrackScores, OfATrackThatChangesItsIdOnce) {
  // One object in four frames; the first three have track 1 and the last has track 2. Each of the four matches of HOTA
  // has TPA / (TPA + FNA + FPA) = 3/4 (three times) or 1/4 (once): the mean is 10/16.
  const TrackScores scores = score({{{20, 1, 10}}, {{20, 1, 10}}, {{20, 1, 10}}, {{20, 2, 10}}});
  EXPECT_DOUBLE_EQ(scores.deta, 1);
  EXPECT_DOUBLE_EQ(scores.assa, 10.0 / 16);
  EXPECT_DOUBLE_EQ(scores.hota, std::sqrt(10.0 / 16));
  EXPECT_DOUBLE_EQ(scores.idf1, 2 * 3 / (4.0 + 4.0));
  EXPECT_EQ(scores.switches, 1);
  EXPECT_EQ(scores.visible_switches, 1);
  EXPECT_DOUBLE_EQ(scores.switches_per_100_frames(), 25);
}

TEST(TrackScores, OfTwoObjectsThatSwapTheirTracks) {
  const Frame before{{20, 1, 10}, {30, 2, 10}}, after{{20, 2, 10}, {30, 1, 10}};
  const TrackScores scores = score({before, before, after, after});
  // Each pair is together in two of four frames: 2 / (4 + 4 - 2).
  EXPECT_DOUBLE_EQ(scores.assa, 1.0 / 3);
  EXPECT_DOUBLE_EQ(scores.idf1, 0.5);
  EXPECT_EQ(scores.switches, 2);
}

TEST(TrackScores, CountSimilarityByLevels) {
  // An IoU of 0.6 is a match at the levels 0.05 to 0.6, which are 12 of 19.
  const TrackScores scores = score({{{20, 1, 6}, {20, 0, 4}}});
  EXPECT_NEAR(scores.deta, 12.0 / 19, 1e-12);
  EXPECT_NEAR(scores.hota, 12.0 / 19, 1e-12);
  EXPECT_DOUBLE_EQ(scores.hota50, 1);
  EXPECT_DOUBLE_EQ(scores.idf1, 1);
}

TEST(TrackScores, CountMissesAndFalseAlarms) {
  // Object 30 is missed, and track 3 is a second one on object 20: one hit, one miss, one false alarm.
  const TrackScores scores = score({{{20, 1, 9}, {20, 3, 1}, {30, 0, 10}}});
  EXPECT_NEAR(scores.hota50, std::sqrt(1.0 / 3), 1e-12);
  EXPECT_DOUBLE_EQ(scores.idf1, 2 * 1 / (2.0 + 2.0));
}

TEST(TrackScores, DoNotCountTracksOfTheSupport) {
  const TrackScores scores = score({{{1, 5, 100}, {1, 6, 20}, {20, 6, 10}, {20, 1, 90}}});
  EXPECT_EQ(scores.tracks, 1);
  EXPECT_DOUBLE_EQ(scores.hota50, 1);
}

TEST(TrackScores, TellSwitchesAfterOcclusionApart) {
  const Frame seen{{20, 1, 10}, {30, 3, 10}}, hidden{{30, 3, 10}}, again{{20, 2, 10}, {30, 3, 10}};
  const TrackScores scores = score({seen, hidden, again});
  EXPECT_EQ(scores.switches, 1);
  EXPECT_EQ(scores.visible_switches, 0);
  // An object that can be seen, but has no track for a while, did not hide.
  EXPECT_EQ(score({seen, {{20, 0, 10}, {30, 3, 10}}, again}).visible_switches, 1);
}

TEST(TrackScores, KeepATrackThatStillFits) {
  // Track 2 fits better in the second frame, but track 1 fits well enough to stay.
  const TrackScores scores = score({{{20, 1, 10}}, {{20, 1, 10}, {30, 1, 9}, {20, 0, 0}}});
  EXPECT_EQ(scores.switches, 0);
}

TEST(TrackScores, LeaveOutSmallRegions) {
  const TrackScores scores = score({{{20, 1, 99}, {30, 2, 100}}}, 100);
  EXPECT_EQ(scores.objects, 1);
  EXPECT_EQ(scores.tracks, 1);
  EXPECT_DOUBLE_EQ(scores.hota, 1);
}

}  // namespace
}  // namespace segserve::eval
