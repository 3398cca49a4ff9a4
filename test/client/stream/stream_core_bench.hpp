#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "client/stream/stream_core.hpp"
#include "gtest/gtest.h"
#include "proto/wire/byte_run.hpp"
#include "proto/wire/status_message.hpp"
#include "test/client/client_scenes.hpp"
#include "test/client/stream/outgoing_message.hpp"

namespace segserve::client {

/// A core between an application and servers that do what the test says.
class Bench {
 public:
  explicit Bench(StreamOptions options = {}, std::vector<std::string> addresses = {"a", "b"})
      : core_(options, std::move(addresses), 0, 1), payload_(*cloud_payload(flat_cloud(10, 10))) {}

  std::uint64_t send(FrameOptions options = {}) { return core_.accept(payload_, std::move(options), now_); }

  void pass(std::chrono::milliseconds time) {
    now_ += time;
    act();
  }

  /// Lets the core act; remembers the connections that it wants.
  void act() {
    for (const auto& action : core_.tick(now_).actions) {
      actions_.push_back(action);
      if (action.kind == StreamCore::Action::kOpen) connections_.push_back(action.connection);
    }
  }

  /// Everything that a connection has to say now.
  std::vector<v1::SegmentStreamRequest> sent(StreamCore::ConnectionId id) {
    std::vector<v1::SegmentStreamRequest> messages;
    for (Outgoing outgoing; core_.next_message(id, outgoing, now_);) messages.push_back(received(outgoing));
    return messages;
  }
  std::vector<v1::SegmentStreamRequest> sent() { return sent(connections_.back()); }

  /// Numbers on the wire of the frames begun in these messages.
  static std::vector<std::uint64_t> headers(const std::vector<v1::SegmentStreamRequest>& messages) {
    std::vector<std::uint64_t> numbers;
    for (const v1::SegmentStreamRequest& message : messages) {
      if (message.has_frame()) numbers.push_back(message.frame().sequence());
    }
    return numbers;
  }
  std::size_t begun() { return headers(sent()).size(); }

  void answer(v1::SegmentStreamResponse response, std::size_t connection = 0) {
    core_.on_message(connection == 0 ? connections_.back() : connection, response, now_);
  }

  void open(std::uint32_t frames = 4, std::uint64_t bytes = 1'000'000) {
    act();
    sent();
    v1::SegmentStreamResponse response;
    response.mutable_opened()->mutable_credit()->set_frames(frames);
    response.mutable_opened()->mutable_credit()->set_bytes(bytes);
    response.mutable_opened()->set_max_chunk_bytes(256 << 10);
    answer(response);
  }

  static v1::SegmentStreamResponse outcome(std::uint64_t number, v1::OutcomeKind kind) {
    v1::SegmentStreamResponse response;
    response.mutable_outcome()->set_sequence(number);
    response.mutable_outcome()->set_kind(kind);
    return response;
  }
  void end(std::uint64_t number, v1::OutcomeKind kind = v1::OUTCOME_KIND_RESULT) { answer(outcome(number, kind)); }
  void fail(std::uint64_t number, const absl::Status& status) {
    v1::SegmentStreamResponse response = outcome(number, v1::OUTCOME_KIND_FAILED);
    *response.mutable_outcome()->mutable_status() = wire::to_message(status);
    answer(response);
  }
  void close(const absl::Status& status) { core_.on_closed(connections_.back(), status, now_); }

  /// Sequence and kind of all outcomes that can be taken.
  std::vector<std::pair<std::uint64_t, OutcomeKind>> taken() {
    std::vector<std::pair<std::uint64_t, OutcomeKind>> ends;
    while (auto raw = core_.take_outcome()) {
      ends.emplace_back(raw->outcome.sequence, raw->outcome.kind);
      last_ = raw->outcome;
    }
    return ends;
  }

  StreamCore core_;
  Payload payload_;
  Time now_{std::chrono::hours(1)};
  std::vector<StreamCore::Action> actions_;
  std::vector<StreamCore::ConnectionId> connections_;
  Outcome last_;
};

inline std::pair<std::uint64_t, OutcomeKind> ended(std::uint64_t sequence, OutcomeKind kind) {
  return {sequence, kind};
}

}  // namespace segserve::client
