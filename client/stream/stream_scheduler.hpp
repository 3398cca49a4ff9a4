// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/fleet/server_list.hpp"
#include "client/stream/frame_dispatch.hpp"
#include "client/stream/frame_queue.hpp"
#include "client/stream/outgoing_message.hpp"
#include "client/stream/server_links.hpp"
#include "segserve/client/stream_options.hpp"

namespace segserve::client {

/// All that a stream decides: which frame goes to which server and when, what is sent again and what is given up. A
/// frame that was accepted has exactly one outcome, whatever connections do.
///
/// Knows no threads, no transport and no clock: StreamThreads brings the lock, the time, and the calls that carry the
/// messages.
class StreamScheduler {
 public:
  /// `seed` makes waits random, and the server to begin with.
  StreamScheduler(StreamOptions options, std::uint32_t seed);
  StreamScheduler(const StreamScheduler&) = delete;
  StreamScheduler& operator=(const StreamScheduler&) = delete;

  // The application's calls.

  enum class Admission { kOpen, kWait, kRefused };
  /// Whether accept() may be called.
  Admission admission() const;
  /// Why admission() is kRefused.
  absl::Status refusal() const;
  /// Takes a frame, if admission() is kOpen, and returns its sequence: 1, 2, 3 and so on.
  std::uint64_t accept(FrameRequest request, Time now);
  /// The frame ends as kCancelled unless its result is faster. Unknown and finished frames are left alone.
  void cancel(std::uint64_t sequence, Time now);
  /// Tells that no more frames will come.
  void finish_sending() { finished_sending_ = true; }
  /// All frames without an outcome end as kCancelled, and the connections break at the next tick.
  void close(Time now);

  bool has_outcome() const { return frames_.has_outcome(); }
  std::optional<UndecodedOutcome> take_outcome() { return frames_.take_outcome(); }
  /// True if no outcome will ever come.
  bool exhausted() const { return (finished_sending_ || closed_ || !fatal_.ok()) && frames_.empty(); }

  // The passing of time.

  /// Replaces the list of servers, which is empty at first.
  void set_servers(const ServerList& list);
  struct Tick {
    std::vector<LinkAction> actions;
    Time wake_at;          ///< the next tick is due then, and after any change
    bool trouble = false;  ///< a server has failed since the last tick
  };
  Tick tick(Time now);
  /// As in Tick, if calls of next_message() have made that earlier.
  std::optional<Time> next_dispatch(Time now) { return dispatch_.next_change(now); }

  // Reports of the transport. Unknown connections are ignored.

  /// How many frames have got an outcome so far. A call of next_message() may end some that come too late.
  std::uint64_t ended() const { return frames_.ended(); }
  /// Fills in the next message of a connection; false if there is none now.
  bool next_message(ConnectionId id, OutgoingMessage& outgoing, Time now);
  /// Whether nothing will be sent on the connection any more.
  bool wants_half_close(ConnectionId id);
  void on_sign_of_life(ConnectionId id, Time now) { links_.on_sign_of_life(id, now); }
  void on_probe_answered(ConnectionId id, Time now) { links_.on_probe_answered(id, now); }
  /// True if there may be something for the application or a tick to do.
  bool on_message(ConnectionId id, v1::SegmentStreamResponse& message, Time now);
  void on_closed(ConnectionId id, const absl::Status& status, Time now);

  // Segmentation in this process.

  struct LocalJob {
    std::uint64_t sequence = 0;
    Payload payload;
    Options options;
    wire::Outputs outputs;
    std::optional<Prompts> prompts;
    std::optional<wire::TrackRequest> tracking;
    Time deadline;
  };
  /// A frame that shall be segmented here, because no server is in reach.
  std::optional<LocalJob> take_local_job(Time now);
  void on_local_result(std::uint64_t sequence, absl::StatusOr<Result> result, Time now);

 private:
  /// Ends the stream if no server was in reach for too long. Returns when to call again, if ever.
  std::optional<Time> check_outage(Time now);
  void on_event(ServerLink& link, StreamProtocol::Event& event, Time now);
  void on_outcome(ServerLink& link, StreamProtocol::Event& event, Time now);
  void on_begun(const ServerLink& link, std::uint64_t sequence, Time now);
  void on_answer(ServerLink& link, QueuedFrame& frame, StreamProtocol::Event& event, Time now);
  void on_failed_frame(ServerLink& link, QueuedFrame& frame, const absl::Status& status, Time now);
  /// Another server may still bring the outcome of the frame, in spite of `error` of one.
  bool is_left_to_another(QueuedFrame& frame, const absl::Status& error);
  /// Tells the servers that still have the frame, which has its outcome, to drop it.
  void cancel_deliveries(std::uint64_t sequence, const std::vector<Delivery>& deliveries, Time now);

  const StreamOptions options_;
  FrameQueue frames_;
  ServerLinks links_;
  FrameDispatch dispatch_;
  std::minstd_rand random_;
  bool finished_sending_ = false;
  bool closed_ = false;
  std::optional<Time> outage_began_;  // unset: a server is in reach, or still computes frames of this stream
  absl::Status fatal_;                // why no server will ever take a frame of this stream
};

}  // namespace segserve::client
