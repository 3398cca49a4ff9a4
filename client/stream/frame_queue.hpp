// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "client/fleet/server_list.hpp"
#include "client/stream/frame_request.hpp"
#include "client/stream/undecoded_outcome.hpp"
#include "segserve/client/frame.hpp"
#include "segserve/client/stream_options.hpp"

namespace segserve::client {

/// Names one connection of a stream; never used twice.
using ConnectionId = std::uint64_t;

/// A frame on its way to one server and back.
struct Delivery {
  ConnectionId connection = 0;
  Time sent_at = {};  ///< when it began
  // As in FrameReport.
  Time header_sent = {}, payload_sent = {}, outcome_begun = {};
  std::uint64_t bytes_sent = 0;
};

/// A frame from hand-over to outcome.
struct QueuedFrame {
  enum class State {
    kWaiting,  ///< to be sent, or to be sent again
    kSent,     ///< in part or as a whole, to one server or several
    kLocal,    ///< being segmented in this process
    kDone,     ///< has its outcome, which nobody has taken yet
  };

  std::uint64_t sequence = 0;
  FrameRequest request;
  Time deadline = {};           ///< of its outcome
  std::optional<Time> expires;  ///< of its use

  State state = State::kWaiting;
  Time ready_at = {};                ///< not to be sent, or sent to yet another server, before
  std::vector<Delivery> deliveries;  ///< kSent: at least one; else none
  std::set<ServerId> failed_at;      ///< servers that did not bring its outcome
  bool cancelled = false;            ///< by the application, while it was kSent
  absl::Status last_error;           ///< why it is sent again
  UndecodedOutcome undecoded;

  FrameReport& report() { return undecoded.outcome.report; }
  /// Null if the frame was not sent on the connection, or that was given up.
  Delivery* delivery_on(ConnectionId connection);
  /// The report tells about this delivery from now on.
  void report_on(const Delivery& delivery);
  /// The connection will not bring the outcome.
  void forget_delivery(ConnectionId connection);
  /// Whether its use ends no later than its deadline.
  bool can_expire() const { return expires && *expires <= deadline; }
  /// The time from which on its result is of no use.
  Time useful_until() const { return can_expire() ? *expires : deadline; }
};

/// The frames of a stream whose outcome was not taken: which may enter, which goes next, how each ends and in which
/// order the outcomes come. Knows neither connections nor transport; time is handed in.
class FrameQueue {
 public:
  /// Uses the limits and the order in `options`, which must outlive the queue.
  explicit FrameQueue(const StreamOptions& options) : options_(options) {}

  bool empty() const { return frames_.empty(); }
  /// How many frames are to be sent.
  std::size_t waiting() const;
  /// How many frames have got an outcome so far.
  std::uint64_t ended() const { return ended_; }
  /// How many frames have no outcome.
  std::size_t unfinished() const;

  /// Takes a frame and returns its sequence: 1, 2, 3 and so on. If too many wait, the oldest of them is dropped.
  std::uint64_t accept(FrameRequest request, Time now);
  /// Null for unknown frames and those whose outcome was taken.
  QueuedFrame* find(std::uint64_t sequence);
  /// The waiting frame that goes next, if the window has room for one; null if there is none. In a stream that follows
  /// objects it is the oldest frame without an outcome, and has the state that the frames before it left.
  QueuedFrame* next_to_send(Time now);
  /// A frame has ended with this state of the tracks, which the next one goes on from.
  void keep_track_state(std::string state) { track_state_ = std::move(state); }
  /// The frames that are sent and have no outcome, in the order of their hand-over.
  std::vector<QueuedFrame*> sent();
  /// The frames without an outcome that were sent on a connection.
  std::vector<QueuedFrame*> sent_on(ConnectionId connection);

  /// Ends a frame whose result would come too late: as kExpired or kFailed, by which of its times is over first.
  void end_late(QueuedFrame& frame, const absl::Status& connection_error, Time now);
  /// Gives the frame its outcome.
  void end(QueuedFrame& frame, OutcomeKind kind, absl::Status status, Time now);
  /// Ends all frames without an outcome.
  void end_all(OutcomeKind kind, const absl::Status& status, Time now);
  /// Ends all frames that are to be sent, as failed.
  void fail_waiting(const absl::Status& status, Time now);
  /// Ends the frames whose time to live or deadline is over. `connection_error` is told to those that know no error of
  /// their own. Returns those that were sent, so that their servers can be told, with the deliveries that they had.
  std::vector<std::pair<QueuedFrame*, std::vector<Delivery>>> end_overdue(const absl::Status& connection_error,
                                                                          Time now);
  /// The frame waits again, from `ready_at` on. It ends instead if it was cancelled, or was sent too often and `error`
  /// is not that the server had no room.
  void send_again(QueuedFrame& frame, absl::Status error, Time ready_at, Time now);
  /// When end_overdue() or next_to_send() have to be asked again, at the latest.
  std::optional<Time> next_change(Time now) const;

  /// Whether an outcome can be taken now, by the order that was asked for.
  bool has_outcome() const;
  std::optional<UndecodedOutcome> take_outcome();

 private:
  std::size_t in_flight() const;
  QueuedFrame* next_in_chain(Time now);

  const StreamOptions& options_;
  std::map<std::uint64_t, QueuedFrame> frames_;  // by sequence
  std::deque<std::uint64_t> done_;               // in the order in which they ended
  std::uint64_t last_sequence_ = 0;
  std::uint64_t ended_ = 0;
  std::string track_state_;  // TrackState::bytes
};

}  // namespace segserve::client
