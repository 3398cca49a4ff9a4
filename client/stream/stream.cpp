// SPDX-License-Identifier: Apache-2.0
#include "segserve/client/stream.hpp"

#include <utility>

#include "client/stream/stream_threads.hpp"
#include "core/base/status_macros.hpp"
#include "proto/wire/traceparent.hpp"

namespace segserve::client {

Stream::Stream(std::shared_ptr<StreamThreads> threads, const wire::CodecOptions& codec)
    : threads_(std::move(threads)), codec_(codec) {
  threads_->start();
}

Stream::~Stream() {
  if (threads_) threads_->stop();
}

Stream& Stream::operator=(Stream&& other) noexcept {
  if (threads_ && threads_ != other.threads_) threads_->stop();
  threads_ = std::move(other.threads_);
  codec_ = other.codec_;
  return *this;
}

absl::StatusOr<std::uint64_t> Stream::send(const CloudView& cloud, FrameOptions options) {
  if (!options.captured) options.captured = Clock::now();  // before the cloud is encoded
  return send_encoded(cloud_payload(cloud, codec_), std::move(options));
}

absl::StatusOr<std::uint64_t> Stream::send(std::shared_ptr<const Cloud> cloud, FrameOptions options) {
  if (!options.captured) options.captured = Clock::now();
  return send_encoded(cloud_payload(std::move(cloud), codec_), std::move(options));
}

absl::StatusOr<std::uint64_t> Stream::send(Payload payload, FrameOptions options) {
  RETURN_IF_ERROR(wire::check_traceparent(options.traceparent));
  return threads_->send(std::move(payload), std::move(options));
}

absl::StatusOr<std::uint64_t> Stream::send_encoded(absl::StatusOr<Payload> payload, FrameOptions options) {
  RETURN_IF_ERROR(payload.status());
  return send(*std::move(payload), std::move(options));
}

std::optional<Outcome> Stream::next(std::optional<std::chrono::milliseconds> timeout) {
  std::optional<Time> until;
  if (timeout) until = Clock::now() + *timeout;
  return threads_->next(until);
}

void Stream::cancel(std::uint64_t sequence) { threads_->cancel(sequence); }

void Stream::finish() { threads_->finish(); }

bool Stream::done() const { return threads_->done(); }

}  // namespace segserve::client
