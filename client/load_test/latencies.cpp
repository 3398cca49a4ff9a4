// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/latencies.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace segserve::bench {

void Latencies::add(double milliseconds) {
  histogram_.record(static_cast<std::uint64_t>(std::llround(std::max(milliseconds, 0.0) * 1000)));
}

void Latencies::add(const Latencies& others) {
  histogram_.add(others.histogram_);
  failed_ += others.failed_;
}

double Latencies::percentile(double percent) const {
  if (count() == 0) return 0;
  // Rounding must not make 99.9 % of 1000 more than 999.
  const double exact = std::ceil(percent / 100 * static_cast<double>(count()) - 1e-9);
  const auto rank = std::clamp<std::uint64_t>(static_cast<std::uint64_t>(std::max(exact, 1.0)), 1, count());
  if (rank > results()) return std::numeric_limits<double>::infinity();
  return static_cast<double>(histogram_.value_at_rank(rank)) / 1000;
}

bool Latencies::bears(double percent) const {
  constexpr double kBeyond = 5;
  return static_cast<double>(count()) * (1 - percent / 100) >= kBeyond - 1e-6;
}

}  // namespace segserve::bench
