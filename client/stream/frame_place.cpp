// SPDX-License-Identifier: Apache-2.0
#include "client/stream/frame_place.hpp"

#include <algorithm>
#include <tuple>
#include <vector>

namespace segserve::client {
namespace {

using std::chrono::nanoseconds;

/// The expected time of the fastest place of which it is known; zero: there is none.
nanoseconds fastest(std::span<const FramePlace> places) {
  nanoseconds best{};
  for (const FramePlace& place : places) {
    const bool is_known = place.expected > nanoseconds(0);
    if (is_known && (best == nanoseconds(0) || place.expected < best)) best = place.expected;
  }
  return best;
}

/// How many frames the place has with one more.
nanoseconds::rep load_with(const FramePlace& place) { return static_cast<nanoseconds::rep>(place.in_flight) + 1; }

/// Up to which cost a place is about as good as the best, in view of how much the times of frames vary.
nanoseconds tie_limit(nanoseconds best) { return best + best / 2 + std::chrono::milliseconds(5); }

}  // namespace

PlaceChoice choose_place(std::span<const FramePlace> places) {
  const nanoseconds unknown = fastest(places);
  const auto cost = [&](const FramePlace& place) {
    const nanoseconds expected = place.expected > nanoseconds(0) ? place.expected : unknown;
    return load_with(place) * std::max(expected, place.oldest);
  };
  const nanoseconds limit = tie_limit(cost(*std::ranges::min_element(places, {}, cost)));
  const auto rank = [&](const FramePlace& place) {
    return std::tuple(cost(place) > limit, !place.has_room, place.in_flight, place.turn);
  };
  const FramePlace& best = *std::ranges::min_element(places, {}, rank);
  if (best.has_room) return {best.connection, std::nullopt};

  // The cost of the best grows with the age of its oldest frame, until it is more than that of one with room.
  std::optional<nanoseconds> next;
  for (const FramePlace& other : places) {
    if (!other.has_room) continue;
    const nanoseconds until_equal = cost(other) / load_with(best) - best.oldest;
    next = std::min(next.value_or(until_equal), until_equal);
  }
  return {best.connection, next};
}

}  // namespace segserve::client
