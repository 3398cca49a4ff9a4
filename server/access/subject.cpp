// SPDX-License-Identifier: Apache-2.0
#include "server/access/subject.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "server/access/access_refusals.hpp"

namespace segserve::server {
namespace {

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

}  // namespace

QuotaLease& QuotaLease::operator=(QuotaLease&& other) noexcept {
  if (this != &other) {
    release();
    subject_ = std::exchange(other.subject_, nullptr);
    points_ = other.points_;
    bytes_ = other.bytes_;
  }
  return *this;
}

void QuotaLease::settle(std::uint64_t points) {
  if (subject_) subject_->take_points(static_cast<double>(points) - static_cast<double>(points_));
  points_ = points;
}

void QuotaLease::refund() {
  if (subject_) subject_->give_back(1, static_cast<double>(points_));
  release();
}

void QuotaLease::release() {
  if (subject_) subject_->release_bytes(bytes_);
  subject_ = nullptr;
}

Subject::Subject(std::string name, const credentials::SubjectLimits& limits, Time now)
    : name_(std::move(name)),
      limits_(limits),
      frames_(limits.frames_per_second.value_or(kNoLimit), now),
      points_(limits.points_per_second.value_or(kNoLimit), now) {}

void Subject::set_limits(const credentials::SubjectLimits& limits, Time now) {
  const MutexLock lock(mutex_);
  if (limits == limits_) return;
  limits_ = limits;
  frames_.set_rate(limits.frames_per_second.value_or(kNoLimit), now);
  points_.set_rate(limits.points_per_second.value_or(kNoLimit), now);
}

credentials::SubjectLimits Subject::limits() const {
  const MutexLock lock(mutex_);
  return limits_;
}

absl::StatusOr<QuotaLease> Subject::admit(std::uint64_t points, std::uint64_t bytes, Time now) {
  // Some frame of the subject ends soon, but nobody knows when.
  constexpr std::chrono::milliseconds kUntilAFrameEnds{100};
  const auto points_wanted = static_cast<double>(points);
  const MutexLock lock(mutex_);
  if (limits_.bytes_in_flight) {
    const std::uint64_t most = *limits_.bytes_in_flight;
    if (bytes > most) return frame_beyond_quota(name_, "bytes_in_flight", most, bytes);
    if (bytes > most - std::min(most, bytes_in_flight_)) {
      return quota_exceeded(name_, "bytes_in_flight", static_cast<double>(most), kUntilAFrameEnds);
    }
  }
  const auto wait_for_frames = frames_.wait_for(1, now), wait_for_points = points_.wait_for(points_wanted, now);
  if (wait_for_frames.count() > 0 && wait_for_frames >= wait_for_points) {
    return quota_exceeded(name_, "frames_per_second", frames_.rate(), frames_.wait_in_line(1, now));
  }
  if (wait_for_points.count() > 0) {
    return quota_exceeded(name_, "points_per_second", points_.rate(), points_.wait_in_line(points_wanted, now));
  }
  frames_.take(1);
  points_.take(points_wanted);
  bytes_in_flight_ += bytes;
  return QuotaLease(shared_from_this(), points, bytes);
}

bool Subject::is_at_rest(Time now) {
  const MutexLock lock(mutex_);
  return bytes_in_flight_ == 0 && frames_.is_full(now) && points_.is_full(now);
}

void Subject::release_bytes(std::uint64_t bytes) {
  const MutexLock lock(mutex_);
  bytes_in_flight_ -= bytes;
}

void Subject::take_points(double points) {
  const MutexLock lock(mutex_);
  if (points > 0) {
    points_.take(points);
  } else {
    points_.give_back(-points);
  }
}

void Subject::give_back(double frames, double points) {
  const MutexLock lock(mutex_);
  frames_.give_back(frames);
  points_.give_back(points);
}

}  // namespace segserve::server
