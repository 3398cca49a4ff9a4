#include "client/stream/stream_call.hpp"

#include <utility>

#include "client/calls/call_status.hpp"

namespace segserve::client {
namespace {

/// The generated stub knows it, but takes no messages other than protobuf's.
constexpr const char* kMethod = "/segserve.v1.SegmentationService/SegmentStream";

}  // namespace

StreamCall::StreamCall(std::uint64_t id, std::string address, std::shared_ptr<grpc::Channel> channel,
                       StreamCallListener& listener)
    : id_(id), address_(std::move(address)), channel_(std::move(channel)), listener_(listener), stub_(channel_) {}

void StreamCall::start() {
  stub_.PrepareBidiStreamingCall(&context_, kMethod, {}, this);
  AddHold();  // for pump(), until the server has no more to say
  {
    const std::lock_guard lock(mutex_);
    closed_ = false;
    StartRead(&response_);
    StartCall();
  }
  pump();
}

void StreamCall::pump() {
  for (bool again = true; again;) {
    {
      const std::lock_guard lock(mutex_);
      again_ = true;  // whoever is at it looks once more
      if (writing_ || closed_) return;
      writing_ = true;
      again_ = false;
      AddHold();  // OnDone waits until this function is through with gRPC
    }
    again = write_once();
    RemoveHold();
  }
}

/// Starts a write if there is something to write. True if there was nothing, but may be by now.
bool StreamCall::write_once() {
  if (listener_.next_message(id_, request_)) {
    StartWrite(&request_);
    return false;
  }
  const bool half_close = listener_.wants_half_close(id_);
  bool again = false;
  {
    const std::lock_guard lock(mutex_);
    writing_ = false;
    if (half_close) closed_ = true;
    again = again_ && !closed_;
  }
  if (half_close) StartWritesDone();
  return again;
}

void StreamCall::OnWriteDone(bool ok) {
  {
    const std::lock_guard lock(mutex_);
    writing_ = false;
    if (!ok) closed_ = true;  // the stream is broken: OnDone will say why
  }
  if (!ok) return;
  listener_.on_written(id_);
  pump();
}

void StreamCall::OnReadDone(bool ok) {
  if (ok) {
    listener_.on_message(id_, response_);
    StartRead(&response_);
    pump();
    return;
  }
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  RemoveHold();
}

void StreamCall::OnDone(const grpc::Status& status) {
  listener_.on_closed(id_, call_status(status, address_));  // from here on `this` may be gone
}

}  // namespace segserve::client
