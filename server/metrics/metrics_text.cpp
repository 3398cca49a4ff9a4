// SPDX-License-Identifier: Apache-2.0
#include "server/metrics/metrics_text.hpp"

#include <algorithm>
#include <iterator>

#include "prometheus/metric_family.h"
#include "prometheus/text_serializer.h"

namespace segserve::server {

std::optional<std::string> MetricsText::text() {
  constexpr int kMostPagesPerSecond = 50;
  {
    const auto now = std::chrono::steady_clock::now();
    const MutexLock lock(mutex_);
    if (now - second_began_ >= std::chrono::seconds(1)) {
      second_began_ = now;
      in_second_ = 0;
    }
    if (++in_second_ > kMostPagesPerSecond) return std::nullopt;
  }
  std::vector<prometheus::MetricFamily> families;
  for (const auto& source : sources_) std::ranges::move(source->Collect(), std::back_inserter(families));
  return prometheus::TextSerializer().Serialize(families);
}

}  // namespace segserve::server
