// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "client/stream/address_book.hpp"
#include "client/stream/frame_queue.hpp"
#include "client/stream/stream_protocol.hpp"
#include "segserve/client/stream_options.hpp"

namespace segserve::client {

/// An order to the transport.
struct LinkAction {
  enum Kind {
    kOpen,         ///< connect to `address`
    kProbe,        ///< ask the server for a sign of life
    kBreak,        ///< cancel the call
    kBreakSilent,  ///< cancel the call, and never use its channel again: the network has cut it
  } kind = kOpen;
  ConnectionId connection = 0;
  std::size_t address = 0;
};

/// A connection to a server, or the attempt to make one.
struct ServerLink {
  ConnectionId id = 0;
  std::size_t address = 0;
  StreamProtocol protocol;
  Time last_sign_of_life;
  std::optional<Time> probed_at = std::nullopt;  ///< unset: there was a sign of life since the last probe
  absl::Status broken = {};                      ///< not OK: given up, and only its end is awaited
  std::uint64_t outcome_bytes = 0;               ///< of the messages since the last FrameOutcome, that one included
};

/// The connections of a stream: which server to connect to and when, and which connection is dead. One connection at a
/// time takes new frames; others may still owe outcomes. Knows neither transport nor clock.
class ServerLinks {
 public:
  /// Uses `options`, which must outlive the links. `first_address` is where to begin, and `seed` makes waits random.
  ServerLinks(const StreamOptions& options, std::vector<std::string> addresses, std::size_t first_address,
              std::uint32_t seed);

  /// Null for unknown connections and those that were given up.
  ServerLink* find(ConnectionId id);
  const std::string& address_of(const ServerLink& link) const { return addresses_[link.address]; }
  /// True if every address has failed since it was reached last.
  bool out_of_reach() const { return book_.nobody_in_reach(); }
  /// The last error of a connection; OK if there was none.
  const absl::Status& last_error() const { return last_error_; }

  /// Makes a connection unless there is one that takes frames. Returns when to call again if it is too early to try.
  std::optional<Time> open_if_needed(Time now);
  /// Probes the connections that owe an answer and are silent, and gives up those whose probe had no answer. Returns
  /// when to call again, if ever.
  std::optional<Time> check_silence(Time now);
  /// Half-closes all connections once their uploads are through: no more frames will come.
  void end_all();
  /// Gives up all connections, which is nobody's fault: the stream was closed.
  void break_all();
  /// Gives up a connection whose server is at fault.
  void break_link(ServerLink& link, LinkAction::Kind kind, absl::Status why, Time now);

  void on_sign_of_life(ConnectionId id, Time now);
  /// The server has granted credit.
  void on_opened(const ServerLink& link) { book_.reached(link.address); }
  /// The server takes no more frames.
  void on_draining(const ServerLink& link, Time now);

  struct End {
    absl::Status why;    ///< never OK
    bool fatal = false;  ///< every server would say so again
  };
  /// The transport says that a connection has ended with `status`. Nothing if it is unknown.
  std::optional<End> on_closed(ConnectionId id, const absl::Status& status, Time now);

  /// The orders to the transport since the last call.
  std::vector<LinkAction> take_actions() { return std::exchange(actions_, {}); }

 private:
  void request(LinkAction::Kind kind, const ServerLink& link) { actions_.push_back({kind, link.id, link.address}); }

  const StreamOptions& options_;
  std::vector<std::string> addresses_;
  AddressBook book_;
  std::map<ConnectionId, ServerLink> links_;
  ConnectionId last_id_ = 0;
  absl::Status last_error_;
  std::vector<LinkAction> actions_;
};

}  // namespace segserve::client
