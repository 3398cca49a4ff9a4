// SPDX-License-Identifier: Apache-2.0
#include "client/stream/frame_place.hpp"

#include <vector>

#include "gtest/gtest.h"

namespace segserve::client {
namespace {

using std::chrono::milliseconds;

ConnectionId chosen(const std::vector<FramePlace>& places) { return choose_place(places).connection; }

TEST(FramePlace, TheFasterServerGetsTheFrame) {
  EXPECT_EQ(chosen({{.connection = 1, .expected = milliseconds(100), .has_room = true},
                    {.connection = 2, .expected = milliseconds(20), .has_room = true}}),
            2U);
}

TEST(FramePlace, ManyFramesMakeAFastServerSlow) {
  EXPECT_EQ(chosen({{.connection = 1, .expected = milliseconds(100), .has_room = true},
                    {.connection = 2, .in_flight = 5, .expected = milliseconds(20), .has_room = true}}),
            1U);
}

TEST(FramePlace, TiesAreBrokenByLoadAndThenByTurn) {
  EXPECT_EQ(chosen({{.connection = 1, .in_flight = 1, .turn = 1, .has_room = true},
                    {.connection = 2, .in_flight = 0, .turn = 2, .has_room = true}}),
            2U);
  EXPECT_EQ(chosen({{.connection = 1, .expected = milliseconds(21), .turn = 9, .has_room = true},
                    {.connection = 2, .expected = milliseconds(20), .turn = 10, .has_room = true}}),
            1U);
}

TEST(FramePlace, AnUnknownServerIsTakenToBeAsFastAsTheFastest) {
  EXPECT_EQ(chosen({{.connection = 1, .in_flight = 1, .expected = milliseconds(20), .has_room = true},
                    {.connection = 2, .in_flight = 0, .has_room = true},
                    {.connection = 3, .in_flight = 0, .expected = milliseconds(90), .has_room = true}}),
            2U);
}

TEST(FramePlace, AServerThatStallsCostsMoreAndMore) {
  std::vector<FramePlace> places{
      {.connection = 1, .in_flight = 1, .expected = milliseconds(20), .oldest = milliseconds(30), .has_room = true},
      {.connection = 2, .expected = milliseconds(300), .has_room = true}};
  EXPECT_EQ(chosen(places), 1U);
  places[0].oldest = milliseconds(400);
  EXPECT_EQ(chosen(places), 2U);
}

TEST(FramePlace, AFastServerWithoutRoomIsWaitedForButNotForever) {
  std::vector<FramePlace> places{
      {.connection = 1, .in_flight = 3, .expected = milliseconds(20), .oldest = milliseconds(20)},
      {.connection = 2, .expected = milliseconds(400), .has_room = true}};
  const PlaceChoice choice = choose_place(places);
  EXPECT_EQ(choice.connection, 1U);
  ASSERT_TRUE(choice.reconsider_in.has_value());
  EXPECT_EQ(*choice.reconsider_in, milliseconds(80));  // four frames of 100 ms are as bad as one of 400
  places[1].has_room = false;
  EXPECT_FALSE(choose_place(places).reconsider_in.has_value()) << "nothing can be sent anyway";
}

}  // namespace
}  // namespace segserve::client
