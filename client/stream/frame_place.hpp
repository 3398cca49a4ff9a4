// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "client/stream/frame_queue.hpp"

namespace segserve::client {

/// A connection that a frame may go to, as far as the choice among several is concerned.
struct FramePlace {
  ConnectionId connection = 0;
  std::size_t in_flight = 0;               ///< frames that the server owes us
  std::chrono::nanoseconds expected = {};  ///< what a frame is likely to take there; zero: unknown
  std::chrono::nanoseconds oldest = {};    ///< the age of the oldest frame in flight; zero: there is none
  std::uint64_t turn = 0;                  ///< when it got its last frame; larger is later
  bool has_room = false;                   ///< the frame may begin now
};

struct PlaceChoice {
  ConnectionId connection = 0;  ///< it may have no room: waiting for it is likely to be faster than the others
  /// When another place may be better although nothing has happened; unset: never.
  std::optional<std::chrono::nanoseconds> reconsider_in;
};

/// The place where a frame is likely to be done first. The cost of a place is the time that a frame takes there, times
/// the frames that it has then. That time is what was learned, or the age of the oldest frame in flight, if that is
/// more: so a server that stalls is noticed before any outcome comes. A place of unknown time is taken to be as fast as
/// the fastest. Among places that cost about the same, the one with the fewest frames is chosen, and then in turn.
/// `places` may not be empty.
PlaceChoice choose_place(std::span<const FramePlace> places);

}  // namespace segserve::client
