// SPDX-License-Identifier: Apache-2.0
#include "segserve/tracking.hpp"

#include <gmock/gmock.h>

#include <atomic>

#include "core/base/status_text.hpp"
#include "test/core/tracking/hand_made_scene.hpp"

namespace segserve {
namespace {

using Eigen::Vector3d;
using test::HandMadeScene;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

const Vector3d kHere(0, 0, 0);
const Vector3d kRed(200, 40, 40), kGreen(40, 180, 60), kBlue(40, 60, 200);

TrackOptions at(double seconds) {
  TrackOptions options;
  options.time = seconds;
  return options;
}

Tracking follow(const Segmentation& segmentation, const TrackState& state, const TrackOptions& options = {}) {
  auto result = track(segmentation, View::world(), state, options);
  EXPECT_TRUE(result.ok()) << result.status();
  return *std::move(result);
}

/// A red row, a green row and a blue row, each shifted. Red has nine supervoxels and the others have six.
HandMadeScene three_rows(const Vector3d& red = Vector3d::Zero(), const Vector3d& green = Vector3d::Zero(),
                         const Vector3d& blue = Vector3d::Zero()) {
  HandMadeScene scene;
  scene.add_row(Vector3d(0, 0, 0) + red, 9, kRed);
  scene.add_row(Vector3d(0, 0.15, 0) + green, 6, kGreen);
  scene.add_row(Vector3d(0, 0.30, 0) + blue, 6, kBlue);
  return scene;
}

/// The state after the three rows were seen in so many frames.
TrackState after(int frames) {
  TrackState state;
  for (int i = 0; i < frames; ++i) state = follow(three_rows().segmentation(), state, at(0.1 * i)).state;
  return state;
}

TEST(Track, GivesIdsToNewObjectsInTheOrderOfTheSegments) {
  const Tracking first = follow(three_rows().segmentation(), {});
  EXPECT_THAT(first.track_of_segment, ElementsAre(1, 2, 3));
  EXPECT_THAT(first.events, ElementsAre(TrackEvent{TrackEventKind::kBorn, 1}, TrackEvent{TrackEventKind::kBorn, 2},
                                        TrackEvent{TrackEventKind::kBorn, 3}));
  EXPECT_EQ(first.state.next_id, 4);
}

TEST(Track, KeepsIdsWhereNothingMoves) {
  const Tracking again = follow(three_rows().segmentation(), after(3));
  EXPECT_THAT(again.track_of_segment, ElementsAre(1, 2, 3));
  EXPECT_THAT(again.events, IsEmpty());
  EXPECT_EQ(again.state.tracks[0].age, 4);
}

TEST(Track, FollowsAnObjectThatMoves) {
  TrackState state = after(2);
  for (int i = 1; i <= 10; ++i) {
    const Vector3d moved(0.03 * i, 0, 0);
    const Tracking now = follow(three_rows(kHere, moved).segmentation(), state, at(0.1 + 0.1 * i));
    EXPECT_THAT(now.track_of_segment, ElementsAre(1, 2, 3)) << i;
    state = now.state;
  }
  EXPECT_NEAR(state.tracks[1].velocity[0], 0.3, 0.06);
  EXPECT_NEAR(state.tracks[0].velocity[0], 0, 0.03);
}

TEST(Track, FindsAnObjectThatJumpsAsFarAsItCanMove) {
  // 0.3 m in half a second is possible, in a tenth it is not.
  const TrackState state = after(2);
  const Segmentation jumped = three_rows(kHere, Vector3d(0.3, 0, 0)).segmentation();
  EXPECT_THAT(follow(jumped, state, at(0.6)).track_of_segment, ElementsAre(1, 2, 3));
  EXPECT_THAT(follow(jumped, state, at(0.2)).track_of_segment, ElementsAre(1, 4, 3));
}

TEST(Track, FindsAnObjectOneLevelUpThatTheCutSplits) {
  HandMadeScene scene;
  const auto left = scene.add_row({0, 0, 0}, 5, kRed), right = scene.add_row({0.1, 0, 0}, 4, kRed);
  scene.merge(left, right, 0.7);
  scene.add_row({0, 0.15, 0}, 6, kGreen);
  scene.add_row({0, 0.30, 0}, 6, kBlue);
  const Segmentation split = scene.segmentation();
  ASSERT_EQ(split.segments, 4);
  const Tracking now = follow(split, after(3));
  EXPECT_EQ(now.cut.segments, 3);
  EXPECT_THAT(now.track_of_segment, ElementsAre(1, 2, 3));
  EXPECT_THAT(now.events, IsEmpty());
}

TEST(Track, JoinsPartsOfAnObjectThatNoNodeHoldsTogether) {
  HandMadeScene scene;
  scene.add_row({0, 0, 0}, 5, kRed);
  scene.add_row({0.1, 0, 0}, 4, kRed);
  scene.add_row({0, 0.15, 0}, 6, kGreen);
  scene.add_row({0, 0.30, 0}, 6, kBlue);
  const Tracking now = follow(scene.segmentation(), after(3));
  EXPECT_THAT(now.track_of_segment, ElementsAre(1, 2, 3));
  EXPECT_THAT(now.events, IsEmpty());
}

TEST(Track, FindsObjectsOneLevelDownThatTheCutMerges) {
  HandMadeScene scene;
  const auto red = scene.add_row({0, 0, 0}, 9, kRed), green = scene.add_row({0, 0.15, 0}, 6, kGreen);
  scene.merge(red, green, 0.3);
  scene.add_row({0, 0.30, 0}, 6, kBlue);
  const Segmentation merged = scene.segmentation();
  ASSERT_EQ(merged.segments, 2);
  const Tracking now = follow(merged, after(3));
  EXPECT_EQ(now.cut.segments, 3);
  EXPECT_THAT(now.track_of_segment, ElementsAre(1, 2, 3));
}

TEST(Track, BelievesTheCutInTheEnd) {
  HandMadeScene scene;
  scene.add_row({0, 0, 0}, 5, kRed);
  scene.add_row({0.1, 0, 0}, 4, kRed);
  TrackState state = after(3);
  bool has_split = false;
  for (int i = 0; i < 12 && !has_split; ++i) {
    const Tracking now = follow(scene.segmentation(), state);
    has_split = now.cut.segments == 2;
    if (has_split) {
      EXPECT_THAT(now.events, testing::Contains(TrackEvent{TrackEventKind::kSplit, 4, 1}));
    }
    EXPECT_EQ(now.track_of_segment[0], 1);
    state = now.state;
  }
  EXPECT_TRUE(has_split);
}

TEST(Track, TellsWhichObjectSwallowedAnother) {
  // No node holds red or green alone.
  HandMadeScene scene;
  std::uint32_t node = scene.add_row({0, 0, 0}, 1, kRed);
  for (int i = 0; i < 9; ++i) {
    if (i > 0) node = scene.merge(node, scene.add_row({0.02 * i, 0, 0}, 1, kRed), 0.1);
    if (i < 6) node = scene.merge(node, scene.add_row({0.02 * i, 0.15, 0}, 1, kGreen), 0.1);
  }
  scene.add_row({0, 0.30, 0}, 6, kBlue);
  TrackState state = after(1);
  const Tracking now = follow(scene.segmentation(), state);
  EXPECT_THAT(now.track_of_segment, ElementsAre(1, 3));
  EXPECT_THAT(now.events, ElementsAre(TrackEvent{TrackEventKind::kMerged, 2, 1}));
}

TEST(Track, RemembersWhatIsOutOfSight) {
  HandMadeScene without_green;
  without_green.add_row({0, 0, 0}, 9, kRed);
  without_green.add_row({0, 0.30, 0}, 6, kBlue);
  TrackState state = after(10);
  TrackOptions options;
  options.keep_lost = 3;
  for (int i = 0; i < 3; ++i) {
    const Tracking now = follow(without_green.segmentation(), state, options);
    const std::vector<TrackEvent> lost{{TrackEventKind::kLost, 2}};
    EXPECT_EQ(now.events, i == 0 ? lost : std::vector<TrackEvent>());
    state = now.state;
  }
  const Tracking again = follow(three_rows().segmentation(), state, options);
  EXPECT_THAT(again.events, ElementsAre(TrackEvent{TrackEventKind::kRecovered, 2}));
  const Tracking ended = follow(without_green.segmentation(), state, options);
  EXPECT_THAT(ended.events, ElementsAre(TrackEvent{TrackEventKind::kEnded, 2}));
  EXPECT_THAT(follow(three_rows().segmentation(), ended.state, options).track_of_segment, ElementsAre(1, 4, 3));
}

/// A table of 30 x 30 supervoxels, of which a track remembers only a few, and a small thing that lies on it.
Segmentation thing_on_table() {
  HandMadeScene scene;
  std::uint32_t table = scene.add_row({0, 0, 0}, 30, kGreen);
  for (int row = 1; row < 30; ++row) table = scene.merge(table, scene.add_row({0, 0.02 * row, 0}, 30, kGreen), 0.2);
  scene.add_row({0.3, 0.3, 0.01}, 3, {80, 160, 90});
  return scene.segmentation();
}

TEST(Track, DoesNotLetASmallThingGrowIntoTheTable) {
  TrackState state = follow(thing_on_table(), {}).state;
  for (int i = 0; i < 3; ++i) {
    const Tracking again = follow(thing_on_table(), state);
    EXPECT_THAT(again.track_of_segment, ElementsAre(1, 2));
    EXPECT_THAT(again.events, IsEmpty());
    state = again.state;
  }
}

TEST(Track, CountsAFragmentLessThanItsObject) {
  // A first frame cuts a strip off the red row; no node of the next one fits both as well as the whole row fits red.
  HandMadeScene first;
  first.add_row({0, 0, 0}, 8, kRed);
  first.add_row({0.16, 0, 0}, 2, kRed);
  TrackState state = follow(first.segmentation(), {}).state;
  ASSERT_EQ(state.tracks.size(), 2);
  HandMadeScene next;  // the strip is a node, but the rest is none
  const auto head = next.add_row({0, 0, 0}, 3, kRed), tail = next.add_row({0.06, 0, 0}, 5, kRed);
  const auto strip = next.add_row({0.16, 0, 0}, 2, kRed);
  next.merge(head, next.merge(tail, strip, 0.2), 0.3);
  const Tracking now = follow(next.segmentation(), state);
  EXPECT_THAT(now.track_of_segment, ElementsAre(1));
  EXPECT_THAT(now.events, ElementsAre(TrackEvent{TrackEventKind::kMerged, 2, 1}));
}

RigidTransform turned(double radians, const Vector3d& by) {
  RigidTransform motion;
  motion.rotation << std::cos(radians), -std::sin(radians), 0, std::sin(radians), std::cos(radians), 0, 0, 0, 1;
  motion.translation = by;
  return motion;
}

Segmentation seen_from(const RigidTransform& pose, Segmentation scene) {
  for (SupervoxelFeatures& features : scene.supervoxel_features) {
    features.centroid = pose.rotation.transpose() * (features.centroid - pose.translation);
  }
  return scene;
}

TEST(Track, FollowsTheMotionOfTheViewThatThePosesTell) {
  TrackOptions options = at(0);
  options.pose = turned(0, {0, 0, 0});
  const TrackState state = follow(three_rows().segmentation(), {}, options).state;
  options = at(0.1);
  options.pose = turned(1.2, {3, -2, 1});
  const Tracking now = follow(seen_from(*options.pose, three_rows().segmentation()), state, options);
  EXPECT_THAT(now.track_of_segment, ElementsAre(1, 2, 3));
  EXPECT_NEAR(now.state.tracks[0].velocity[0], 0, 1e-3);
  const Vector3d place(0.1, 0.2, 0.3);
  EXPECT_LT((options.pose->rotation * (now.motion.rotation * place + now.motion.translation) +
             options.pose->translation - place)
                .norm(),
            1e-12);
}

TEST(Track, EstimatesTheMotionOfTheView) {
  const TrackState state = after(2);
  const RigidTransform pose = turned(0.15, {0.12, -0.1, 0});
  const Tracking now = follow(seen_from(pose, three_rows().segmentation()), state, at(0.2));
  EXPECT_THAT(now.track_of_segment, ElementsAre(1, 2, 3));
  EXPECT_LT((now.motion.rotation - pose.rotation.transpose()).norm(), 1e-3);
  EXPECT_LT((now.motion.translation + pose.rotation.transpose() * pose.translation).norm(), 1e-3);
}

TEST(Track, IsAFunctionOfTheBytesOfTheState) {
  const TrackState state = after(5);
  const Segmentation next = three_rows(kHere, Vector3d(0.01, 0, 0)).segmentation();
  const auto parsed = TrackState::parse(state.bytes());
  ASSERT_TRUE(parsed.ok()) << parsed.status();
  EXPECT_EQ(follow(next, *parsed, at(0.6)).state.bytes(), follow(next, state, at(0.6)).state.bytes());
}

TEST(Track, TakesAnEmptyFrame) {
  const Tracking now = follow(HandMadeScene().segmentation(), after(2));
  EXPECT_EQ(now.cut.segments, 0);
  EXPECT_THAT(now.track_of_segment, IsEmpty());
  EXPECT_EQ(now.state.tracks.size(), 3);
  EXPECT_THAT(follow(three_rows().segmentation(), now.state).track_of_segment, ElementsAre(1, 2, 3));
}

TEST(Track, LeavesSmallSegmentsWithoutId) {
  TrackOptions options;
  options.min_points = 400;  // eight supervoxels
  EXPECT_THAT(follow(three_rows().segmentation(), {}, options).track_of_segment, ElementsAre(1, 0, 0));
}

TEST(Track, FollowsAtMostSoManyObjects) {
  HandMadeScene scene;
  for (int i = 0; i < 300; ++i) scene.add_row({0.1 * (i % 20), 0.1 * (i / 20), 0}, 2, kRed);
  const Tracking first = follow(scene.segmentation(), {});
  EXPECT_EQ(first.state.tracks.size(), TrackState::kMostTracks);
  EXPECT_EQ(std::ranges::count(first.track_of_segment, 0), 300 - static_cast<int>(TrackState::kMostTracks));
  EXPECT_THAT(follow(scene.segmentation(), first.state).events, IsEmpty());
}

TEST(Track, MakesStatesThatCanBeReadOfAnyState) {
  // A state comes from the network, and may say anything within its limits.
  for (const float far : {5e8F, 1e9F, -1e9F}) {
    TrackState state = after(2);
    ASSERT_EQ(state.tracks.size(), 3U);
    state.tracks[0].center = {0.1F, 0, far};  // It is followed by its color and size, or carried on as lost.
    state.tracks[1].velocity = {far, far, far};
    state.tracks[2].axes = {2, 2, 2, -2, 2, 2};
    state.tracks[2].step = 1e9F;
    for (TrackState::Signature& signature : state.tracks[2].signatures) signature.place = {32767, -32767, 32767};
    const auto read = TrackState::parse(state.bytes());
    ASSERT_TRUE(read.ok()) << read.status();
    TrackState next = *read;
    TrackOptions options = at(0.2);
    options.pose = RigidTransform{.rotation = Eigen::Matrix3d::Identity(), .translation = {0, 0, 1e8}};
    for (int frame = 0; frame < 4; ++frame) {
      *options.time += 0.1;
      next = follow(frame == 1 ? HandMadeScene().segmentation() : three_rows().segmentation(), next, options).state;
      const auto again = TrackState::parse(next.bytes());
      ASSERT_TRUE(again.ok()) << again.status();
    }
  }
}

TEST(Track, GivesNoIdTwiceWhereIdsRunOut) {
  TrackState state;
  state.next_id = ~std::uint64_t{0} - 1;
  const Tracking last = follow(three_rows().segmentation(), state);
  EXPECT_THAT(last.track_of_segment, ElementsAre(~std::uint64_t{0} - 1, 0, 0));
  EXPECT_TRUE(TrackState::parse(last.state.bytes()).ok());
}

TEST(Track, NamesAllWrongOptions) {
  TrackOptions options;
  options.max_speed = -1;
  options.min_points = 0;
  options.keep_lost = 1001;
  options.time = std::nan("");
  options.pose.emplace().rotation *= 2;
  const auto result = track(three_rows().segmentation(), View::world(), {}, options);
  EXPECT_EQ(result.status().code(), absl::StatusCode::kInvalidArgument);
  for (const char* name : {"pose", "time", "max_speed", "keep_lost", "min_points"}) {
    EXPECT_THAT(message_of(result.status()), HasSubstr(std::string(name) + ":"));
  }
}

TEST(Track, NeedsTheFeaturesOfTheSupervoxels) {
  Segmentation segmentation = three_rows().segmentation();
  segmentation.supervoxel_features.clear();
  EXPECT_THAT(message_of(track(segmentation, View::world(), {}, {}).status()), HasSubstr("features of its 21"));
}

TEST(Track, StopsWhenItIsCancelled) {
  const std::atomic<bool> cancelled = true;
  const auto result = track(three_rows().segmentation(), View::world(), after(2), {}, StopToken(&cancelled));
  EXPECT_EQ(result.status().code(), absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace segserve
