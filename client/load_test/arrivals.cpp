// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/arrivals.hpp"

namespace segserve::bench {

Arrivals Arrivals::constant(double rate, double first) { return {rate, first, false, 0}; }

Arrivals Arrivals::poisson(double rate, std::uint64_t seed) { return {rate, 0, true, seed}; }

double Arrivals::next() {
  if (!random_) return (first_ + count_++) / rate_;
  return time_ += std::exponential_distribution<double>(rate_)(engine_);
}

}  // namespace segserve::bench
