// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/mutex.hpp"
#include "segserve/client/frame.hpp"

namespace segserve::bench {

/// The phases of a run: a warm-up, the measured window, in which frames are sent as before, and the drain, in which
/// nothing is sent and outcomes are waited for. The window may be ended before its time. Thread-safe.
class RunClock {
 public:
  using Time = client::Time;
  using Duration = client::Clock::duration;

  RunClock(Time begin, Duration warm_up, Duration window, Duration drain);

  Time begin() const { return begin_; }
  Time measured_from() const { return measured_from_; }
  Time end() const ABSL_LOCKS_EXCLUDED(mutex_);        ///< of the window
  Time drain_end() const ABSL_LOCKS_EXCLUDED(mutex_);  ///< outcomes that come later do not count
  bool is_measured(Time time) const { return time >= measured_from_ && time < end(); }

  /// Ends the window at `now`, if that is earlier, and gives the drain so much time.
  void stop(Time now, Duration drain) ABSL_LOCKS_EXCLUDED(mutex_);
  /// Does the same for a user who does not want to wait.
  void interrupt(Time now, Duration drain) ABSL_LOCKS_EXCLUDED(mutex_);
  bool interrupted() const ABSL_LOCKS_EXCLUDED(mutex_);
  /// Waits for a time in the window. False if the window ends before, or has ended so long ago that nobody who wanted
  /// to do something at that time may do it still; this is told at once.
  bool sleep_until(Time until) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  const Time begin_, measured_from_;
  mutable Mutex mutex_;
  CondVar stopped_;
  Time end_ ABSL_GUARDED_BY(mutex_), drain_end_ ABSL_GUARDED_BY(mutex_);
  bool interrupted_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace segserve::bench
