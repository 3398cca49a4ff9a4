// SPDX-License-Identifier: Apache-2.0
#include "client/stream/stream_transport.hpp"

#include <utility>

#include "client/calls/call_status.hpp"

namespace segserve::client {
namespace {

/// The generated stub has the method, but it takes no messages other than protobuf's.
constexpr const char* kMethod = "/segserve.v1.SegmentationService/SegmentStream";

}  // namespace

StreamTransport::StreamTransport(std::uint64_t connection, std::string address, std::shared_ptr<grpc::Channel> channel,
                                 StreamTransportListener& listener)
    : connection_(connection),
      address_(std::move(address)),
      channel_(std::move(channel)),
      listener_(listener),
      stub_(channel_) {}

void StreamTransport::start() {
  stub_.PrepareBidiStreamingCall(&context_, kMethod, {}, this);
  AddHold();  // for pump(), until the server has no more to say
  {
    const MutexLock lock(mutex_);
    closed_ = false;
    StartRead(&response_);
    StartCall();
  }
  pump();
}

void StreamTransport::pump() {
  for (bool again = true; again;) {
    {
      const MutexLock lock(mutex_);
      again_ = true;  // the thread that writes looks once more
      if (writing_ || closed_) return;
      writing_ = true;
      again_ = false;
      AddHold();  // OnDone must wait until this function needs gRPC no more
    }
    again = write_once();
    RemoveHold();
  }
}

/// Starts a write if there is something to write. True if there was nothing, but may be by now.
bool StreamTransport::write_once() {
  if (listener_.next_message(connection_, request_)) {
    StartWrite(&request_);
    return false;
  }
  const bool half_close = listener_.wants_half_close(connection_);
  bool again = false;
  {
    const MutexLock lock(mutex_);
    writing_ = false;
    if (half_close) closed_ = true;
    again = again_ && !closed_;
  }
  if (half_close) StartWritesDone();
  return again;
}

void StreamTransport::OnWriteDone(bool ok) {
  {
    const MutexLock lock(mutex_);
    writing_ = false;
    if (!ok) closed_ = true;  // the stream is broken: OnDone will say why
  }
  if (!ok) return;
  listener_.on_written(connection_);
  pump();
}

void StreamTransport::OnReadDone(bool ok) {
  if (ok) {
    listener_.on_message(connection_, response_);
    StartRead(&response_);
    pump();
    return;
  }
  {
    const MutexLock lock(mutex_);
    closed_ = true;
  }
  RemoveHold();
}

void StreamTransport::OnDone(const grpc::Status& status) {
  // `this` may be destroyed from here on.
  listener_.on_closed(connection_, call_status(status, address_), handshake_failed(status));
}

}  // namespace segserve::client
