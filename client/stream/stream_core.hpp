#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "client/stream/address_book.hpp"
#include "client/stream/connection.hpp"
#include "segserve/client/frame.hpp"
#include "segserve/client/payload.hpp"
#include "segserve/client/stream_options.hpp"

namespace segserve::client {

/// An outcome whose result is still a message.
struct RawOutcome {
  Outcome outcome;
  v1::SegmentationResult message;  ///< kResult and not local
  Payload payload;                 ///< kResult: what it is the result of
  wire::Outputs outputs;           ///< what was asked for, known since the frame was accepted
};

/// All that a stream decides, without threads, transport or clock: which frame goes where and when, what is sent
/// again, what is given up. A frame that was accepted has exactly one outcome, whatever connections do. The
/// caller (StreamDriver) brings a mutex, the time, and calls that carry the messages.
class StreamCore {
 public:
  using ConnectionId = std::uint64_t;

  StreamCore(StreamOptions options, std::vector<std::string> addresses, std::size_t first_address, std::uint32_t seed);

  // What the application does.

  enum class Admission { kOpen, kWait, kRefused };
  /// Whether accept() may be called.
  Admission admission() const;
  /// Takes a frame; returns its sequence: 1, 2, ..
  std::uint64_t accept(Payload payload, FrameOptions options, Time now);
  /// It ends as CANCELLED unless its result is faster. Unknown and finished frames are left alone.
  void cancel(std::uint64_t sequence, Time now);
  /// No more frames will come.
  void finish_sending() { finished_sending_ = true; }
  /// Whatever has no outcome ends as CANCELLED; connections are to be broken.
  void close(Time now);
  /// Why no frame can ever pass (a server that does not know us, options that it refuses); OK as long as one can.
  const absl::Status& fatal() const { return fatal_; }

  bool has_outcome() const;
  std::optional<RawOutcome> take_outcome();
  /// True if no outcome will ever come.
  bool exhausted() const { return (finished_sending_ || closed_ || !fatal_.ok()) && frames_.empty(); }
  /// Frames without an outcome.
  std::size_t unfinished() const;

  // What time does.

  struct Action {
    enum Kind {
      kOpen,         ///< a connection to `address`
      kProbe,        ///< ask its server for a sign of life
      kBreak,        ///< cancel it
      kBreakSilent,  ///< the same, and never use this way to the address again: it is cut
    } kind = kOpen;
    ConnectionId connection = 0;
    std::size_t address = 0;
  };
  struct Tick {
    std::vector<Action> actions;
    Time wake_at;  ///< call again then at the latest, and after any change
  };
  Tick tick(Time now);

  // What connections do. Unknown ids are ignored.

  /// Fills in the next message of a connection; false if there is none now.
  bool next_message(ConnectionId id, Outgoing& outgoing, Time now);
  bool wants_half_close(ConnectionId id) const;
  void on_sign_of_life(ConnectionId id, Time now);
  /// True if something changed that the application or time may act upon.
  bool on_message(ConnectionId id, v1::SegmentStreamResponse& message, Time now);
  void on_closed(ConnectionId id, const absl::Status& status, Time now);

  // Segmentation in this process.

  struct LocalJob {
    std::uint64_t sequence = 0;
    Payload payload;
    Options options;
    wire::Outputs outputs;
    Time deadline;
  };
  /// A frame that shall be segmented here, because no server is in reach.
  std::optional<LocalJob> take_local_job(Time now);
  void on_local_result(std::uint64_t sequence, absl::StatusOr<Result> result, Time now);

  /// What a StreamOpen says.
  static v1::StreamOpen open_message(const StreamOptions& options);

 private:
  enum class State { kWaiting, kSent, kLocal, kDone };
  struct Frame {
    std::uint64_t sequence = 0;
    State state = State::kWaiting;
    Payload payload;
    FrameOptions options;
    Time captured, deadline, ready_at;
    std::optional<Time> expires;
    bool cancelled = false;
    ConnectionId connection = 0;
    absl::Status last_error;
    RawOutcome raw;
  };
  struct Link {
    Connection protocol;
    std::size_t address = 0;
    Time last_sign;
    std::optional<Time> probed_at = std::nullopt;
    absl::Status broken = {};         ///< not OK: given up, only its end is to come
    std::uint64_t outcome_bytes = 0;  ///< of the messages since the last FrameOutcome, which is among them
  };

  bool waits(const Frame& frame) const { return frame.state == State::kWaiting; }
  std::size_t waiting() const;
  std::size_t occupied() const;
  Frame* pick(Time now);
  Frame* find(std::uint64_t sequence);
  v1::FrameHeader header_of(const Frame& frame, Time now) const;
  void begin_frame(Link& link, ConnectionId id, Time now);
  void end_frame(Frame& frame, OutcomeKind kind, absl::Status status, Time now);
  void again(Frame& frame, absl::Status error, Time ready_at, Time now);
  void on_outcome(ConnectionId id, Connection::Event& event, Time now);
  void on_failed_frame(Frame& frame, const absl::Status& status, Time now);
  void give_up(const absl::Status& status, Time now);
  void check_frames(Time now);
  void check_links(Time now, Tick& tick);
  void open_link(Time now, Tick& tick);
  void break_link(ConnectionId id, Link& link, Action::Kind kind, absl::Status why, Time now);
  bool out_of_reach() const { return book_.nobody_in_reach(); }

  StreamOptions options_;
  std::vector<std::string> addresses_;
  AddressBook book_;
  std::minstd_rand random_;
  std::map<std::uint64_t, Frame> frames_;  // by sequence: all whose outcome was not taken
  std::deque<std::uint64_t> done_;         // in the order in which they ended
  std::map<ConnectionId, Link> links_;
  std::uint64_t last_sequence_ = 0;
  ConnectionId last_connection_ = 0;
  bool finished_sending_ = false, closed_ = false;
  absl::Status fatal_;
  absl::Status last_error_;      // of a connection
  std::vector<Action> actions_;  // that tick() has not told yet
};

}  // namespace segserve::client
