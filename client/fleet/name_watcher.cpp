// SPDX-License-Identifier: Apache-2.0
#include "client/fleet/name_watcher.hpp"

#include <random>
#include <utility>

#include "client/fleet/lookup_schedule.hpp"
#include "core/base/mutex.hpp"

namespace segserve::client {

/// The thread may outlive the watcher, and owns this together with it.
struct NameWatcher::State {
  State(HostName host_name, HostLookup host_lookup)
      : name(std::move(host_name)), lookup(std::move(host_lookup)), schedule(std::random_device()()) {}

  /// Waits until a lookup is due. False once the watcher is gone.
  bool wait_for_lookup() ABSL_LOCKS_EXCLUDED(mutex) {
    const MutexLock lock(mutex);
    while (!stopped) {
      const auto due = schedule.due();
      if (!due || *due <= Clock::now()) break;
      changed.wait_until(mutex, *due);
    }
    looks_up = !stopped;
    return looks_up;
  }
  /// False once the watcher is gone.
  bool end_lookup() ABSL_LOCKS_EXCLUDED(mutex) {
    const MutexLock lock(mutex);
    looks_up = false;
    return !stopped;
  }

  const HostName name;
  const HostLookup lookup;
  Mutex mutex;
  CondVar changed;
  bool stopped ABSL_GUARDED_BY(mutex) = false;
  bool looks_up ABSL_GUARDED_BY(mutex) = false;  ///< the thread may be blocked for long
  LookupSchedule schedule ABSL_GUARDED_BY(mutex);
};

NameWatcher::NameWatcher(HostName name, HostLookup lookup, OnAnswer on_answer)
    : state_(std::make_shared<State>(std::move(name), std::move(lookup))),
      thread_([state = state_, on_answer = std::move(on_answer)] { run(state, on_answer); }) {}

NameWatcher::~NameWatcher() {
  bool is_blocked = false;
  {
    const MutexLock lock(state_->mutex);
    state_->stopped = true;
    is_blocked = state_->looks_up;
    state_->changed.notify_all();
  }
  if (is_blocked) {
    thread_.detach();
  } else {
    thread_.join();
  }
}

void NameWatcher::on_trouble(Time now) {
  const MutexLock lock(state_->mutex);
  state_->schedule.on_trouble(now);
  state_->changed.notify_all();
}

void NameWatcher::run(const std::shared_ptr<State>& state, const OnAnswer& on_answer) {
  while (state->wait_for_lookup()) {
    const auto answer = state->lookup(state->name);
    if (!state->end_lookup()) return;
    const bool is_news = on_answer(answer) || !answer.ok();
    const MutexLock lock(state->mutex);
    state->schedule.on_answer(is_news, Clock::now());
  }
}

}  // namespace segserve::client
