// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "client/stream/service_time.hpp"
#include "segserve/client/frame.hpp"

namespace segserve::client {

/// How long a server takes for the frames of a stream. If there are others, what was learned counts for less and less,
/// so that a server that was slow is tried again. Knows no clock.
class ServerPace {
 public:
  /// `is_one_of_several`: the stream has other servers, too.
  void set_one_of_several(bool is_one_of_several) { fades_ = is_one_of_several; }
  /// A frame took so long.
  void add(ServiceTime::Duration took, Time now);
  /// A frame took at least so long, and was given up then.
  void add_at_least(ServiceTime::Duration time, Time now);

  /// The time that a frame is likely to take; zero if it is not known.
  ServiceTime::Duration expected(Time now) const;
  /// A time that few frames exceed; zero: unknown. It does not fade.
  ServiceTime::Duration bound() const { return time_.bound(); }

 private:
  /// The weight that earlier measurements still have.
  double share_left(Time now) const;

  bool fades_ = false;
  ServiceTime time_;
  std::optional<Time> learned_at_;
};

}  // namespace segserve::client
