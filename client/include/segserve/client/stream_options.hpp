#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "proto/wire/codec_message.hpp"
#include "segserve/client/frame.hpp"

namespace segserve::client {

/// What happens to frames that come faster than they are segmented.
enum class WhenBehind : std::uint8_t {
  kBlock,       ///< send() waits. Nothing is lost
  kDropOldest,  ///< the oldest frame that waits ends as DROPPED: for robots that want the newest scene
  kReject,      ///< send() fails with RESOURCE_EXHAUSTED
};

/// In which order outcomes come.
enum class Order : std::uint8_t {
  kSent,  ///< in the order of send()
  kDone,  ///< as soon as each is known
};

/// Frames are pure functions of their bytes and options, so sending them again is always safe.
struct RetryOptions {
  /// A frame that was sent so often without an answer, or was told so often to come again, fails.
  std::uint32_t max_attempts = 5;
  /// Waits before an address is tried again: doubling from the first to the largest, shortened at random by up to
  /// a half. A server's RetryInfo makes them longer.
  std::chrono::milliseconds first_backoff{50};
  std::chrono::milliseconds max_backoff{5000};
};

struct StreamOptions {
  std::string client_name = {};   ///< for the server's logs; at most 256 bytes
  Options options = {};           ///< of frames that have none of their own
  wire::CodecOptions codec = {};  ///< how clouds are sent
  wire::Outputs outputs = {.labels = true, .supervoxels = true, .tree = true};
  Order order = Order::kSent;
  WhenBehind when_behind = WhenBehind::kBlock;

  /// Frames that are sent, or answered and not yet taken by next(). The server's credit may make it less.
  std::size_t max_in_flight = 4;
  /// Frames that wait in this process until they may be sent; at least 1.
  std::size_t max_waiting = 1;
  /// Bytes of payload in flight to ask the server for; 0: as it thinks fit. A frame of more bytes than it
  /// grants fails.
  std::uint64_t wanted_bytes = 0;

  /// A frame without an outcome fails after this time with DEADLINE_EXCEEDED.
  std::chrono::milliseconds frame_timeout{30'000};
  /// A connection that shows no sign of life for so long is given up. (A server that computes for long is
  /// asked, and answers.)
  std::chrono::milliseconds progress_timeout{5000};

  RetryOptions retry = {};
  /// When no address is in reach: true, frames wait until one is or their time is over; false, they fail
  /// with UNAVAILABLE.
  bool wait_for_server = true;
  /// When no address is in reach, segment in this process, by the same core.
  bool fallback_to_local = false;

  /// Gets every outcome, one at a time, on a thread that does nothing else; next() then gives none. It may take its
  /// time and may call send(). It must not destroy the stream and must not throw.
  std::function<void(Outcome)> on_outcome = nullptr;
};

/// Every fault, by name; empty if there is none.
std::vector<FieldViolation> violations(const StreamOptions& options);

}  // namespace segserve::client
