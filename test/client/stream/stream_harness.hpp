// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "client/stream/frame_request.hpp"
#include "client/stream/stream_scheduler.hpp"
#include "gtest/gtest.h"
#include "proto/wire/byte_run.hpp"
#include "proto/wire/request_message.hpp"
#include "proto/wire/result_message.hpp"
#include "proto/wire/status_message.hpp"
#include "test/client/client_scenes.hpp"
#include "test/client/stream/received_message.hpp"

namespace segserve::client {

/// A StreamScheduler whose application, clock, transport and servers are the test. Functions without a connection talk
/// about the newest one. Servers are numbered from 1, in the order of their addresses, and so are connections.
class StreamHarness {
 public:
  explicit StreamHarness(const StreamOptions& options = {}, const std::vector<std::string>& addresses = {"a"})
      : scheduler_(options, 1), options_(options) {
    set_servers(addresses);
  }

  /// From now on these are the servers. Those that were known before keep their numbers.
  void set_servers(const std::vector<std::string>& addresses) {
    ServerList list;
    for (const std::string& address : addresses) {
      const ServerId id = ids_.try_emplace(address, ids_.size() + 1).first->second;
      list.servers.push_back({.id = id, .target = address, .authority = "", .address = address});
    }
    scheduler_.set_servers(list);
  }

  /// Hands a frame of 100 points over: 1500 bytes. Returns its sequence.
  std::uint64_t send(FrameOptions options = {}) {
    return scheduler_.accept(resolve(payload_, std::move(options), options_, now_), now_);
  }

  void pass(std::chrono::milliseconds time) {
    now_ += time;
    act();
  }

  /// Ticks, and notes what the scheduler asks of the transport.
  void act() {
    for (const LinkAction& action : scheduler_.tick(now_).actions) {
      actions_.push_back(action);
      if (action.kind == LinkAction::kOpen) connections_.push_back(action.connection);
    }
  }

  /// All messages that a connection sends now.
  std::vector<v1::SegmentStreamRequest> sent(ConnectionId id) {
    std::vector<v1::SegmentStreamRequest> messages;
    for (OutgoingMessage outgoing; scheduler_.next_message(id, outgoing, now_);) messages.push_back(received(outgoing));
    return messages;
  }
  std::vector<v1::SegmentStreamRequest> sent() { return sent(connections_.back()); }

  /// The numbers on the wire of the frames that begin in these messages.
  static std::vector<std::uint64_t> headers(const std::vector<v1::SegmentStreamRequest>& messages) {
    std::vector<std::uint64_t> numbers;
    for (const v1::SegmentStreamRequest& message : messages) {
      if (message.has_frame()) numbers.push_back(message.frame().sequence());
    }
    return numbers;
  }
  /// How many frames begin now.
  std::size_t begun() { return headers(sent()).size(); }
  std::size_t begun_on(ConnectionId id) { return headers(sent(id)).size(); }

  /// The server says this. Connections are counted from 1; 0 stands for the newest.
  void answer(v1::SegmentStreamResponse response, ConnectionId connection = 0) {
    scheduler_.on_message(connection == 0 ? connections_.back() : connection, response, now_);
  }

  /// Makes connections, on the newest of which the server grants this credit.
  void open(std::uint32_t frames = 4, std::uint64_t bytes = 1'000'000) {
    act();
    open_on(connections_.back(), frames, bytes);
  }
  /// On each connection that there is its server grants this credit.
  void open_all(std::uint32_t frames = 4) {
    act();
    for (const ConnectionId id : connections_) open_on(id, frames);
  }
  /// On a new connection the server grants this credit.
  void open_on(ConnectionId id, std::uint32_t frames = 4, std::uint64_t bytes = 1'000'000) {
    sent(id);
    v1::SegmentStreamResponse response;
    response.mutable_opened()->mutable_credit()->set_frames(frames);
    response.mutable_opened()->mutable_credit()->set_bytes(bytes);
    response.mutable_opened()->set_max_chunk_bytes(256 << 10);
    answer(response, id);
  }

  static v1::SegmentStreamResponse outcome(std::uint64_t number, v1::OutcomeKind kind) {
    v1::SegmentStreamResponse response;
    response.mutable_outcome()->set_sequence(number);
    response.mutable_outcome()->set_kind(kind);
    return response;
  }
  /// The server ends the frame that has this number on the wire.
  void end(std::uint64_t number, v1::OutcomeKind kind = v1::OUTCOME_KIND_RESULT) { answer(outcome(number, kind)); }
  /// The server of a connection ends a frame with a result.
  void end_on(ConnectionId id, std::uint64_t number) { answer(outcome(number, v1::OUTCOME_KIND_RESULT), id); }
  void fail(std::uint64_t number, const absl::Status& status) {
    v1::SegmentStreamResponse response = outcome(number, v1::OUTCOME_KIND_FAILED);
    *response.mutable_outcome()->mutable_status() = wire::to_message(status);
    answer(response);
  }
  /// The connection ends.
  void close(const absl::Status& status) { scheduler_.on_closed(connections_.back(), status, now_); }

  /// Takes all outcomes that there are: sequence and kind of each.
  std::vector<std::pair<std::uint64_t, OutcomeKind>> taken() {
    std::vector<std::pair<std::uint64_t, OutcomeKind>> ends;
    while (auto undecoded = scheduler_.take_outcome()) {
      ends.emplace_back(undecoded->outcome.sequence, undecoded->outcome.kind);
      last_ = undecoded->outcome;
    }
    return ends;
  }

  StreamScheduler scheduler_;
  const StreamOptions options_;
  const Payload payload_ = *cloud_payload(flat_cloud(10, 10));
  Time now_{std::chrono::hours(1)};
  std::vector<LinkAction> actions_;        ///< all so far
  std::vector<ConnectionId> connections_;  ///< all so far
  Outcome last_;                           ///< that was taken
  std::map<std::string, ServerId> ids_;
};

inline std::pair<std::uint64_t, OutcomeKind> ended(std::uint64_t sequence, OutcomeKind kind) {
  return {sequence, kind};
}

}  // namespace segserve::client
