#include "segserve/client/stream.hpp"

#include <utility>

#include "client/stream/stream_driver.hpp"
#include "fmt/format.h"

namespace segserve::client {

const char* name(OutcomeKind kind) {
  switch (kind) {
    case OutcomeKind::kResult:
      return "RESULT";
    case OutcomeKind::kDropped:
      return "DROPPED";
    case OutcomeKind::kExpired:
      return "EXPIRED";
    case OutcomeKind::kCancelled:
      return "CANCELLED";
    case OutcomeKind::kFailed:
      return "FAILED";
  }
  return "?";
}

std::vector<FieldViolation> violations(const StreamOptions& options) {
  constexpr std::size_t kMostFrames = 1024;
  std::vector<FieldViolation> faults = segserve::violations(options.options);
  const auto in_range = [&faults](const char* name, std::int64_t value, std::int64_t minimum, std::int64_t maximum) {
    if (value < minimum || value > maximum) {
      faults.push_back({name, fmt::format("{} is not in [{}, {}]", value, minimum, maximum)});
    }
  };
  constexpr std::int64_t kDay = 86'400'000;
  in_range("max_in_flight", static_cast<std::int64_t>(options.max_in_flight), 1, kMostFrames);
  in_range("max_waiting", static_cast<std::int64_t>(options.max_waiting), 1, kMostFrames);
  in_range("frame_timeout", options.frame_timeout.count(), 1, kDay);
  in_range("progress_timeout", options.progress_timeout.count(), 2, kDay);
  in_range("retry.max_attempts", options.retry.max_attempts, 1, 1'000'000);
  in_range("retry.first_backoff", options.retry.first_backoff.count(), 1, kDay);
  in_range("retry.max_backoff", options.retry.max_backoff.count(), options.retry.first_backoff.count(), kDay);
  return faults;
}

Stream::Stream(std::shared_ptr<StreamDriver> driver, const wire::CodecOptions& codec)
    : driver_(std::move(driver)), codec_(codec) {
  driver_->start();
}

Stream::~Stream() {
  if (driver_) driver_->stop();
}

Stream& Stream::operator=(Stream&& other) noexcept {
  if (driver_ && driver_ != other.driver_) driver_->stop();
  driver_ = std::move(other.driver_);
  codec_ = other.codec_;
  return *this;
}

absl::StatusOr<std::uint64_t> Stream::send(const CloudView& cloud, FrameOptions options) {
  if (!options.captured) options.captured = Clock::now();
  return send_made(cloud_payload(cloud, codec_), std::move(options));
}

absl::StatusOr<std::uint64_t> Stream::send(std::shared_ptr<const Cloud> cloud, FrameOptions options) {
  if (!options.captured) options.captured = Clock::now();
  return send_made(cloud_payload(std::move(cloud), codec_), std::move(options));
}

absl::StatusOr<std::uint64_t> Stream::send_made(absl::StatusOr<Payload> payload, FrameOptions options) {
  if (!payload.ok()) return payload.status();
  return driver_->send(*std::move(payload), std::move(options));
}

absl::StatusOr<std::uint64_t> Stream::send(Payload payload, FrameOptions options) {
  return driver_->send(std::move(payload), std::move(options));
}

std::optional<Outcome> Stream::next(std::optional<std::chrono::milliseconds> timeout) {
  std::optional<Time> until;
  if (timeout) until = Clock::now() + *timeout;
  auto raw = driver_->next(until);
  if (!raw) return std::nullopt;
  return finished(*std::move(raw));
}

void Stream::cancel(std::uint64_t sequence) { driver_->cancel(sequence); }

void Stream::finish() { driver_->finish(); }

bool Stream::done() const { return driver_->exhausted(); }

}  // namespace segserve::client
