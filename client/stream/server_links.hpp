// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "client/fleet/server_book.hpp"
#include "client/fleet/server_list.hpp"
#include "client/stream/frame_queue.hpp"
#include "client/stream/silence.hpp"
#include "client/stream/stream_protocol.hpp"
#include "segserve/client/stream_options.hpp"

namespace segserve::client {

/// An order to the transport.
struct LinkAction {
  enum Kind {
    kOpen,         ///< connect to `server`
    kRenew,        ///< use the call's channel for no other call, so that the next one makes a new connection
    kProbe,        ///< ask the server for a sign of life
    kBreak,        ///< cancel the call
    kBreakSilent,  ///< cancel the call, and never use its channel again: the network has cut it
  } kind = kOpen;
  ConnectionId connection = 0;
  Server server;
};

/// A connection to a server, or the attempt to make one.
struct ServerLink {
  ConnectionId id = 0;
  Server server;
  StreamProtocol protocol;
  Silence silence;
  absl::Status broken = {};         ///< not OK: given up, and only its end is awaited
  std::uint64_t outcome_bytes = 0;  ///< of the messages since the last FrameOutcome, that one included

  bool has_answered = false;                       ///< some frame has got an outcome
  std::optional<Time> rests_until = std::nullopt;  ///< one of several servers that had no room for a frame
  bool is_old = false;                             ///< shall be replaced, and takes frames until it is

  bool rests(Time now) const { return rests_until && *rests_until > now; }
  /// Whether it takes new frames, when it does not rest.
  bool takes_frames() const { return broken.ok() && protocol.opened() && !protocol.ending() && !silence.is_suspect(); }
};

/// The connections of a stream: which servers to connect to and when, and which connection is dead. Each server has at
/// most one that takes new frames; others may still owe outcomes. Knows neither transport nor clock.
class ServerLinks {
 public:
  /// Uses `options`, which must outlive the links. `seed` makes waits and the choice among many servers random.
  ServerLinks(const StreamOptions& options, std::uint32_t seed);

  /// Replaces the list of servers. Those that are no longer on it get no new frames.
  void set_servers(const ServerList& list);

  /// Null for unknown connections and those that were given up.
  ServerLink* find(ConnectionId id);
  /// The connections that take new frames.
  std::vector<ServerLink*> taking_frames();
  /// Whether there are several servers to choose from.
  bool is_fleet() const { return servers_.size() > 1 && options_.max_servers > 1; }
  /// True if every server has failed since it was reached last, or none is found, and no connection takes frames.
  bool out_of_reach() const;
  /// The last error of a connection or of a name; OK if there was none.
  const absl::Status& last_error() const { return last_error_; }

  /// Makes the connections that are missing. Returns when to tick again, if ever.
  std::optional<Time> open_missing(Time now);
  /// Tells the usual time of a server's frames; zero if it is not known.
  using UsualTime = absl::FunctionRef<Clock::duration(ServerId server)>;
  /// Probes the connections that owe an answer and are silent, and gives up those whose probe had no answer. Returns
  /// when to call again, if ever.
  std::optional<Time> check_silence(UsualTime usual_time, Time now);
  /// Half-closes all connections once their uploads are through: no more frames will come.
  void end_all();
  /// Gives up all connections, which is nobody's fault: the stream was closed.
  void break_all();
  /// Gives up a connection whose server is at fault.
  void break_link(ServerLink& link, LinkAction::Kind kind, absl::Status why, Time now);

  void on_sign_of_life(ConnectionId id, Time now);
  /// Somebody has answered the probe. Of a stream that is not open yet, that was another server, behind the same proxy.
  void on_probe_answered(ConnectionId id, Time now);
  /// The server has granted credit. The connection takes the place of an old one, which finishes what it has.
  void on_opened(const ServerLink& link);
  /// The server asks for another connection. New frames go to the old one until there is another.
  void on_old(ServerLink& link);
  /// The server takes no more frames.
  void on_draining(const ServerLink& link, Time now);

  struct End {
    absl::Status why;    ///< never OK
    bool fatal = false;  ///< every server would say so again
    ServerId server = 0;
    bool useless = false;  ///< the server took frames and answered none
  };
  /// The transport says that a connection has ended with `status`. Nothing if it is unknown.
  std::optional<End> on_closed(ConnectionId id, const absl::Status& status, Time now);

  /// The orders to the transport since the last call.
  std::vector<LinkAction> take_actions() { return std::exchange(actions_, {}); }
  /// Whether a server has failed since the last call, so that its name may stand for others by now.
  bool take_trouble() { return std::exchange(trouble_, false); }

 private:
  void request(LinkAction::Kind kind, const ServerLink& link) { actions_.push_back({kind, link.id, link.server}); }
  void on_failed(ServerId server, Time now, std::optional<std::chrono::milliseconds> asked_for);
  void open(const Server& server, Time now);
  /// The servers to be connected to: the first of the list that are in reach, and those before them.
  std::vector<Server> wanted() const;
  bool has_link(ServerId server) const;

  const StreamOptions& options_;
  std::minstd_rand random_;
  std::vector<Server> servers_;                   // in the order in which this stream prefers them
  std::map<ServerId, std::uint32_t> preference_;  // random: smaller ones first
  ServerBook book_;
  std::map<ConnectionId, ServerLink> links_;
  ConnectionId last_id_ = 0;
  absl::Status last_error_;
  std::vector<LinkAction> actions_;
  SilenceClock silence_clock_;
  bool trouble_ = false;
};

}  // namespace segserve::client
