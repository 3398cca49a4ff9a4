// SPDX-License-Identifier: Apache-2.0
#include "client/stream/service_time.hpp"

namespace segserve::client {

void ServiceTime::add(Duration took) {
  if (!mean_) {
    mean_ = took;
    deviation_ = took / 2;
    return;
  }
  const Duration off = took - *mean_;
  deviation_ += ((off < Duration(0) ? -off : off) - deviation_) / 4;
  *mean_ += off / 8;
}

void ServiceTime::add_at_least(Duration time) {
  if (!mean_ || time > *mean_) add(time);
}

}  // namespace segserve::client
