// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <random>
#include <vector>

#include "client/stream/frame_place.hpp"
#include "client/stream/frame_queue.hpp"
#include "client/stream/hedge_budget.hpp"
#include "client/stream/server_links.hpp"
#include "client/stream/server_pace.hpp"
#include "segserve/client/stream_options.hpp"

namespace segserve::client {

/// Decides which frame goes to which of the connections that take frames, and which frames go to a second server as
/// well. Knows neither transport nor clock.
class FrameDispatch {
 public:
  /// Uses all three, which must outlive it. `seed` decides with which server it begins.
  FrameDispatch(const StreamOptions& options, FrameQueue& frames, ServerLinks& links, std::uint32_t seed);

  /// The servers are others now.
  void set_servers(const std::vector<Server>& servers);
  /// Starts to send a frame on the connection, which must take frames and have its turn, if there is one that is best
  /// sent there.
  void begin_frame(ServerLink& link, Time now);
  /// When begin_frame() may decide otherwise although nothing has happened, if ever.
  std::optional<Time> next_change(Time now);

  /// The usual time of the server's frames; zero if it is not known.
  Clock::duration usual_time(ServerId server, Time now) { return record_of(server).pace.expected(now); }

  /// The server has failed the frame, and perhaps asked to wait. Returns when the frame should be sent again: at once
  /// if there is another server to try.
  Time on_failed(ServerLink& link, QueuedFrame& frame, const absl::Status& error, std::chrono::milliseconds wait,
                 Time now);
  /// The connection of a server is lost. `useless`: it took frames and answered none.
  void on_lost(ServerId server, bool useless, Time now);
  /// The server has answered a frame with a result, or its result would have come too late.
  void on_answered(ServerId server, const Delivery& delivery, Time now);
  void on_too_late(ServerId server, const Delivery& delivery, Time now);

 private:
  struct Record {
    ServerPace pace;
    std::uint64_t turn = 0;
  };
  Record& record_of(ServerId server);
  /// The next frame for the connection, null if there is none. Frames that would come too late, judged by how long the
  /// last ones took, end instead if others wait: a server that is behind would otherwise be late with all of them.
  QueuedFrame* next_frame(ServerLink& link, Time now);
  /// A frame that shall go to a second server, and best to this one; null if there is none.
  QueuedFrame* frame_to_copy(const ServerLink& link, Time now);
  enum class CopyReason { kNone, kSilent, kLate };
  CopyReason copy_reason(QueuedFrame& frame, Time now);
  /// Nothing if the frame fits none of the connections. No connection (0) if all that it fits rest.
  std::optional<PlaceChoice> choose(const QueuedFrame& frame, Time now);
  /// The connections to servers at which the frame has not failed; all of them if it has failed at each.
  static std::vector<ServerLink*> untried(const QueuedFrame& frame, const std::vector<ServerLink*>& links);
  FramePlace place_on(const ServerLink& link, std::uint64_t bytes, Time now);
  void send(QueuedFrame& frame, ServerLink& link, Time now);

  const StreamOptions& options_;
  FrameQueue& frames_;
  ServerLinks& links_;
  std::minstd_rand random_;
  std::map<ServerId, Record> records_;
  std::uint64_t last_turn_ = std::minstd_rand::max();
  HedgeBudget budget_;
  std::optional<Time> reconsider_at_;
};

}  // namespace segserve::client
