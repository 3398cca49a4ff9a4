#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "absl/status/statusor.h"
#include "client/calls/channels.hpp"
#include "client/stream/stream_call.hpp"
#include "client/stream/stream_core.hpp"

namespace segserve::client {

/// Brings a StreamCore to life: a mutex around it, a thread that lets time pass, one that calls back the application if
/// that is asked for, calls that carry the messages, and a thread for segmentation in this process once that is needed.
class StreamDriver final : public StreamCallListener {
 public:
  StreamDriver(std::shared_ptr<Channels> channels, StreamOptions options);

  void start();
  /// Cancels what is unfinished, and returns when no thread and no call is left.
  void stop();

  absl::StatusOr<std::uint64_t> send(Payload payload, FrameOptions options);
  void cancel(std::uint64_t sequence);
  void finish();
  std::optional<RawOutcome> next(std::optional<Time> until);
  bool exhausted();

  bool next_message(std::uint64_t call, Outgoing& outgoing) override;
  bool wants_half_close(std::uint64_t call) override;
  void on_written(std::uint64_t call) override;
  void on_message(std::uint64_t call, v1::SegmentStreamResponse& message) override;
  void on_closed(std::uint64_t call, const absl::Status& status) override;

 private:
  /// No outcome will come any more, and whoever gets them has had them. Expects the lock.
  bool all_taken() const { return core_.exhausted() && !calling_back_; }

  struct Probe;
  void drive();
  void segment_locally();
  void perform(const StreamCore::Action& action);
  void open(const StreamCore::Action& action);
  void probe(const StreamCore::Action& action);
  void on_probed(std::uint64_t call, bool alive);
  void call_back();
  void pump();
  /// Wakes whoever waits for a change. Needs the lock.
  void changed();

  const std::shared_ptr<Channels> channels_;
  const StreamOptions options_;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t changes_ = 0;
  StreamCore core_;
  bool calling_back_ = false;  // with an outcome that was taken
  std::map<std::uint64_t, std::shared_ptr<StreamCall>> calls_;
  std::map<std::uint64_t, std::shared_ptr<Probe>> probes_;
  std::vector<std::shared_ptr<void>> ended_;  // calls and probes that the driver's thread shall destroy
  bool stopping_ = false;
  std::atomic<bool> stop_local_{false};
  std::thread thread_, callback_thread_, local_thread_;
};

/// The result of a frame as the application gets it.
Outcome finished(RawOutcome raw);

}  // namespace segserve::client
