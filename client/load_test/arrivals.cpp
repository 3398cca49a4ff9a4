// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/arrivals.hpp"

namespace segserve::bench {

Arrivals Arrivals::constant(double rate, double first) { return {rate, first, false, 0}; }

Arrivals Arrivals::poisson(double rate, std::uint64_t seed) { return {rate, 0, true, seed}; }

double round_seconds(const std::vector<double>& times) {
  const auto count = static_cast<double>(times.size());
  return (times.back() - times.front()) * count / (count - 1);
}

Arrivals Arrivals::recorded(const std::vector<double>& times, double speed, std::size_t first) {
  Arrivals arrivals(speed, 0, false, 0);
  arrivals.times_ = times;
  arrivals.next_ = first;
  arrivals.first_ = times[first];
  return arrivals;
}

double Arrivals::next_recorded() {
  const std::size_t frame = next_ % times_.size();
  const std::size_t rounds = next_ / times_.size();
  ++next_;
  return (static_cast<double>(rounds) * round_seconds(times_) + times_[frame] - first_) / rate_;
}

double Arrivals::next() {
  if (!times_.empty()) return next_recorded();
  if (!random_) return (first_ + count_++) / rate_;
  return time_ += std::exponential_distribution<double>(rate_)(engine_);
}

}  // namespace segserve::bench
