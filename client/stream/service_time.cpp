// SPDX-License-Identifier: Apache-2.0
#include "client/stream/service_time.hpp"

#include <algorithm>
#include <chrono>

namespace segserve::client {
namespace {

ServiceTime::Duration times(ServiceTime::Duration time, double factor) {
  return std::chrono::duration_cast<ServiceTime::Duration>(time * factor);
}

}  // namespace

void ServiceTime::add(Duration took, double least_weight) {
  if (!mean_) {
    mean_ = took;
    deviation_ = took / 2;
    return;
  }
  const Duration off = took - *mean_;
  deviation_ += times((off < Duration(0) ? -off : off) - deviation_, std::max(1.0 / 4, least_weight));
  *mean_ += times(off, std::max(1.0 / 8, least_weight));
}

void ServiceTime::add_at_least(Duration time, double least_weight) {
  if (!mean_ || time > *mean_) add(time, least_weight);
}

}  // namespace segserve::client
