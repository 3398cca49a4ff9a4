// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "segserve/client/frame.hpp"
#include "segserve/tracking.hpp"
#include "segserve/wire/codec.hpp"
#include "segserve/wire/outputs.hpp"

namespace segserve::client {

/// Says what happens to frames that come faster than they are segmented.
enum class WhenBehind : std::uint8_t {
  kBlock,       ///< send() waits; nothing is lost but by a frame's own deadline
  kDropOldest,  ///< the oldest frame that waits ends as kDropped: for robots that want the newest scene
  kReject,      ///< send() fails with RESOURCE_EXHAUSTED
};

/// The order in which outcomes come.
enum class Order : std::uint8_t {
  kSent,  ///< in the order of send()
  kDone,  ///< as soon as each is known
};

/// How frames and calls are repeated. Repeating is always safe, because results are pure functions of the bytes and
/// options that are sent.
struct RetryOptions {
  /// How often a frame or call is sent, from 1. It then fails with its last error.
  std::uint32_t max_attempts = 5;
  /// The time before an address is tried again doubles from the first to the largest, and is shortened at random by up
  /// to a half. It is never less than the server asked for (RetryInfo).
  std::chrono::milliseconds first_backoff{50};
  std::chrono::milliseconds max_backoff{5000};
};

struct StreamOptions {
  std::string client_name = {};   ///< for the server's logs; at most 256 bytes
  Options options = {};           ///< of frames that have none of their own
  wire::CodecOptions codec = {};  ///< how clouds are sent
  /// The arrays of results, for frames that do not say so themselves.
  wire::Outputs outputs = {.labels = true, .supervoxels = true, .tree = true};
  /// If it is set, objects keep their ids from frame to frame (Result::tracks). The stream then has a single frame on
  /// its way at a time, in the order of send(), because each frame needs the state that the one before leaves: the
  /// server that gets it does not matter. A frame that ends without a result leaves the state as it was, and the next
  /// one goes on from there. The time of a frame is its stamp, or else when it was captured; one that was taken earlier
  /// than the frame before counts as if hardly any time had passed. `time` and `pose` have no meaning here:
  /// FrameOptions has them.
  std::optional<TrackOptions> tracking = std::nullopt;
  Order order = Order::kSent;
  WhenBehind when_behind = WhenBehind::kBlock;

  /// How many frames may be sent, or have a result that next() has not taken; 1 to 1024. The server's credit may allow
  /// fewer.
  std::size_t max_in_flight = 4;
  /// How many frames may wait in this process until they may be sent; 1 to 1024.
  std::size_t max_waiting = 1;
  /// How many bytes of payload in flight the server is asked for; 0: as it thinks fit. A frame of more bytes than the
  /// server grants fails.
  std::uint64_t wanted_bytes = 0;

  /// How many servers the stream has connections to at the same time; 1 to 64. Each frame goes to the one that is
  /// likely to be done with it first. If the addresses stand for more servers, each stream uses others.
  std::size_t max_servers = 16;
  /// A frame that has no outcome after this time is sent to a second server as well, and the first answer counts; up to
  /// a day; 0: never. At most one frame in ten is sent so, counted over some time, because a fleet that is late with
  /// all frames has no use for even more of them.
  std::chrono::milliseconds hedge_after{0};

  /// A frame without an outcome fails after this time with DEADLINE_EXCEEDED; 1 ms to a day. It fails earlier if others
  /// wait and too little time is left for its answer, judged by the frames before.
  std::chrono::milliseconds frame_timeout{30'000};
  /// A connection without a sign of life for this time is given up; 2 ms to a day. A server that computes for long
  /// answers a probe in between. With several servers, one that has been silent for a second and owes the answer to a
  /// probe gets no more frames until it speaks, and what it has is sent to another server, too.
  std::chrono::milliseconds progress_timeout{5000};

  RetryOptions retry = {};
  /// When no address is in reach: true, frames wait until one is or their time is over; false, they fail with
  /// UNAVAILABLE.
  bool wait_for_server = true;
  /// When no address has been in reach for this long, up to a day, all unfinished frames fail with a status that
  /// is_outage() knows, and the stream takes no more; 0: never. It has no meaning with `fallback_to_local`.
  std::chrono::milliseconds longest_outage{0};
  /// Whether frames are segmented in this process, by the same core, when no address is in reach.
  bool fallback_to_local = false;

  /// Gets every outcome, one at a time, on a thread that does nothing else; next() then gives none. It may take its
  /// time, which delays no deadline, and may call send(). It must not destroy the stream and must not throw.
  std::function<void(Outcome)> on_outcome = nullptr;
};

/// Whether a frame failed, or was not taken, because of StreamOptions::longest_outage. The code of the status is
/// UNAVAILABLE.
bool is_outage(const absl::Status& status);

/// All faults, with the name of each field; empty if there is none.
std::vector<FieldViolation> violations(const StreamOptions& options);

}  // namespace segserve::client
