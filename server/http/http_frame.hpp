// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/access/access_grant.hpp"
#include "server/access/client_share.hpp"
#include "server/frames/frame_computation.hpp"
#include "server/frames/frame_settings.hpp"
#include "server/http/http_message.hpp"
#include "server/memory/frame_memory.hpp"
#include "server/observe/frame_record.hpp"
#include "server/rpc/segmentation_service.hpp"

namespace segserve::server {

/// One frame that came by HTTP, from its header until its client has read the answer. It does what SegmentCall does for
/// a unary call of gRPC, on the same ledger, queue, workers, limits and observers. The owner of its answer is the frame
/// itself, so that the lease of its memory ends when the answer has been read.
class HttpFrame final : public std::enable_shared_from_this<HttpFrame> {
 public:
  using Time = FrameSettings::Time;
  using Done = std::function<void(absl::StatusOr<HttpAnswer>)>;

  /// The computation that is asked for. `decode` and `encode` own what they need.
  struct Order {
    FrameSettings settings;
    DecodePayload decode;
    std::function<absl::StatusOr<HttpAnswer>(wire::Result& result, const CloudView& cloud)> encode;
  };

  /// The service's InFlightCalls must have admitted the call; the frame releases it. One that is destroyed before it
  /// was submitted or refused counts as cancelled. `deadline` is that of the caller.
  HttpFrame(SegmentationService::Parts service, AccessGrant grant, Caller caller, std::optional<Time> deadline);
  HttpFrame(const HttpFrame&) = delete;
  HttpFrame& operator=(const HttpFrame&) = delete;
  ~HttpFrame();

  const std::optional<Time>& deadline() const { return deadline_; }
  Time arrival() const { return record_.arrival; }
  /// The record for the log.
  FrameRecord& record() { return record_; }

  /// Leases memory for a payload of so many bytes. Errors are those of FrameMemory.
  absl::Status reserve(std::uint64_t bytes) { return memory_.receive(bytes); }

  /// Queues the frame, whose payload has `bytes` bytes. `done` is called exactly once, from any thread.
  void submit(Order order, std::uint64_t bytes, Done done);
  /// Ends a frame that is not submitted.
  void refuse(const absl::Status& status) { end(status).IgnoreError(); }

  /// The client has gone.
  void cancel();
  /// The server closes: the frame ends with UNAVAILABLE, DRAINING.
  void abort();
  /// Ends the frame if its deadline passed while it waited.
  void on_tick(Time now);

 private:
  absl::Status queue(std::uint64_t bytes);
  void run(std::size_t worker);
  void withdraw(const absl::Status& status);
  void finish(absl::StatusOr<HttpAnswer> answer);
  absl::Status end(const absl::Status& status);

  SegmentationService::Parts service_;
  const AccessGrant grant_;
  const ClientShare share_;
  const std::optional<Time> deadline_;
  QuotaLease quota_;
  FrameMemory memory_;
  FrameRecord record_;
  Order order_;
  Done done_;
  std::shared_ptr<HttpFrame> self_;  // while it is submitted
  std::atomic<bool> cancelled_{false}, aborted_{false};
  std::atomic<bool> submitted_{false};  // `ticket_` is set
  WorkerPool::Ticket ticket_ = 0;
  bool ended_ = false;  // its record is out
};

}  // namespace segserve::server
