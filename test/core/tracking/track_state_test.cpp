// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <limits>
#include <random>

#include "core/base/status_text.hpp"
#include "segserve/tracking.hpp"
#include "test/core/tracking/hand_made_scene.hpp"

namespace segserve {
namespace {

using testing::HasSubstr;

TrackState example() {
  test::HandMadeScene scene;
  for (int i = 0; i < 5; ++i) scene.add_row({0, 0.1 * i, 0}, 4 + static_cast<std::size_t>(i), {40.0 * i, 100, 50});
  TrackOptions options;
  options.time = 12.5;
  options.pose = RigidTransform{};
  TrackState state = track(scene.segmentation(), View::world(), {}, options)->state;
  state.plane = TrackState::Plane{{0, 0, 1}, 0.25F};
  return state;
}

/// The bytes with a checksum that is right.
std::string with_checksum(std::string bytes) {
  bytes.resize(bytes.size() - 8);
  std::uint64_t hash = 0xCBF29CE484222325U;
  for (const char c : bytes) hash = (hash ^ static_cast<std::uint8_t>(c)) * 0x100000001B3U;
  for (unsigned shift = 0; shift < 64; shift += 8) bytes += static_cast<char>(hash >> shift & 0xFFU);
  return bytes;
}

std::string fault(const std::string& bytes) { return message_of(TrackState::parse(bytes).status()); }

TEST(TrackState, ComesBackFromItsBytes) {
  const TrackState state = example();
  ASSERT_EQ(state.tracks.size(), 5);
  const auto parsed = TrackState::parse(state.bytes());
  ASSERT_TRUE(parsed.ok()) << parsed.status();
  EXPECT_EQ(*parsed, state);
  EXPECT_EQ(parsed->bytes(), state.bytes());
}

TEST(TrackState, OfNoBytesKnowsNothing) { EXPECT_EQ(*TrackState::parse(""), TrackState()); }

TEST(TrackState, OfManyObjectsKeepsItsLimit) {
  TrackState state = example();
  TrackState::Track track = state.tracks.back();
  track.signatures.resize(TrackState::kMostSignatures);
  while (state.tracks.size() < TrackState::kMostTracks) track.id = state.next_id++, state.tracks.push_back(track);
  EXPECT_LE(state.bytes().size(), TrackState::kMostBytes);
  EXPECT_TRUE(TrackState::parse(state.bytes()).ok());
  track.id = state.next_id++, state.tracks.push_back(track);
  EXPECT_THAT(fault(state.bytes()), HasSubstr("257 tracks"));
}

TEST(TrackState, IsRefusedIfABitIsWrong) {
  const std::string bytes = example().bytes();
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    std::string damaged = bytes;
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << bit % 8));
    EXPECT_FALSE(TrackState::parse(damaged).ok()) << bit;
  }
}

TEST(TrackState, IsRefusedIfItEndsEarlyOrLate) {
  const std::string bytes = example().bytes();
  for (std::size_t size = 1; size < bytes.size(); ++size) {
    EXPECT_FALSE(TrackState::parse(bytes.substr(0, size)).ok()) << size;
    const std::string early = bytes.substr(0, std::max<std::size_t>(size, 15));
    EXPECT_FALSE(TrackState::parse(with_checksum(early)).ok()) << size;
  }
  EXPECT_THAT(fault(with_checksum(bytes + "x")), HasSubstr("1 bytes follow its end"));
  EXPECT_THAT(fault(std::string(TrackState::kMostBytes + 1, 'x')), HasSubstr("98304 at most"));
}

TEST(TrackState, SaysWhatIsWrong) {
  const TrackState state = example();
  const auto fault_after = [&](auto&& change) {
    TrackState changed = state;
    change(changed);
    return fault(changed.bytes());
  };
  EXPECT_EQ(fault("hello, this is no track state"), "track state: these bytes are none");
  std::string later = state.bytes();
  later[4] = 2;
  EXPECT_THAT(fault(later), HasSubstr("version 2 is not known"));
  EXPECT_THAT(fault_after([](TrackState& s) { s.next_id = 5; }), HasSubstr("track 5 is not above"));
  EXPECT_THAT(fault_after([](TrackState& s) { s.tracks[1].id = 1; }), HasSubstr("track 1 is not above"));
  EXPECT_THAT(fault_after([](TrackState& s) { s.tracks[0].center[1] = std::numeric_limits<float>::infinity(); }),
              HasSubstr("track 1 has a number that is not finite"));
  EXPECT_THAT(fault_after([](TrackState& s) { s.tracks[0].area = std::nanf(""); }), HasSubstr("size"));
  EXPECT_THAT(fault_after([](TrackState& s) { s.tracks[0].step = 0; }), HasSubstr("size"));
  EXPECT_THAT(fault_after([](TrackState& s) { s.pose->rotation(0, 0) = 3; }), HasSubstr("no rigid motion"));
  EXPECT_THAT(fault_after([](TrackState& s) { s.time = std::nan(""); }), HasSubstr("the time"));
  EXPECT_THAT(fault_after([](TrackState& s) { s.plane->offset = 1e30F; }), HasSubstr("the plane"));
}

// Whatever passes the checks can be followed.
TEST(TrackState, OfAStrangerHarmsNothing) {
  test::HandMadeScene scene;
  for (int i = 0; i < 5; ++i) scene.add_row({0, 0.1 * i, 0}, 6, {40.0 * i, 100, 50});
  const Segmentation segmentation = scene.segmentation();
  const std::string bytes = example().bytes();
  std::mt19937 random(1);
  int followed = 0;
  for (int i = 0; i < 3000; ++i) {
    std::string changed = bytes;
    for (int k = 0; k < 1 + i % 4; ++k) changed[random() % changed.size()] = static_cast<char>(random());
    const auto state = TrackState::parse(with_checksum(changed));
    if (!state.ok()) continue;
    const auto result = track(segmentation, View::world(), *state, {});
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_EQ(result->cut.segment_of_leaf.size(), 30);
    EXPECT_TRUE(TrackState::parse(result->state.bytes()).ok());
    ++followed;
  }
  EXPECT_GT(followed, 500);
}

}  // namespace
}  // namespace segserve
