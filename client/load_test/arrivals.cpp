// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/arrivals.hpp"

#include <cmath>
#include <utility>

namespace segserve::bench {
namespace {

/// When a rate that begins with `from` and changes by `slope` each second has brought so many frames.
double time_in_segment(double from, double slope, double frames) {
  // The root of from t + slope t^2 / 2 = frames, in a form that stands a slope of 0.
  return 2 * frames / (from + std::sqrt(std::max(0.0, from * from + 2 * slope * frames)));
}

}  // namespace

double RateSchedule::time_of(double frames) const {
  double begin = 0;
  for (const RateSegment& segment : segments_) {
    const double all = (segment.from + segment.to) / 2 * segment.seconds;
    if (frames <= all && frames > 0) {
      return begin + time_in_segment(segment.from, (segment.to - segment.from) / segment.seconds, frames);
    }
    if (frames <= 0) return begin;
    frames -= all;
    begin += segment.seconds;
  }
  return begin + frames / segments_.back().to;
}

Arrivals Arrivals::constant(RateSchedule schedule, double share, double first) {
  return {std::move(schedule), share, first, false, 0};
}

Arrivals Arrivals::poisson(RateSchedule schedule, double share, std::uint64_t seed) {
  return {std::move(schedule), share, 0, true, seed};
}

double round_seconds(const std::vector<double>& times) {
  const auto count = static_cast<double>(times.size());
  return (times.back() - times.front()) * count / (count - 1);
}

Arrivals Arrivals::recorded(const std::vector<double>& times, double speed, std::size_t first) {
  Arrivals arrivals(RateSchedule({}), 1, 0, false, 0);
  arrivals.times_ = times;
  arrivals.speed_ = speed;
  arrivals.next_ = first;
  arrivals.first_ = times[first];
  return arrivals;
}

double Arrivals::next_recorded() {
  const std::size_t frame = next_ % times_.size();
  const std::size_t rounds = next_ / times_.size();
  ++next_;
  return (static_cast<double>(rounds) * round_seconds(times_) + times_[frame] - first_) / speed_;
}

double Arrivals::next() {
  if (!times_.empty()) return next_recorded();
  if (random_) return schedule_.time_of((due_ += std::exponential_distribution<double>(1)(engine_)) / share_);
  const double at = schedule_.time_of(due_ / share_);
  due_ += 1;
  return at;
}

}  // namespace segserve::bench
