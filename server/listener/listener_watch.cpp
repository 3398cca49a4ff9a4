// SPDX-License-Identifier: Apache-2.0
#include "server/listener/listener_watch.hpp"

#include <algorithm>
#include <utility>

#include "absl/status/statusor.h"
#include "server/frames/catch_exceptions.hpp"
#include "server/listener/file_descriptors.hpp"
#include "spdlog/spdlog.h"

namespace segserve::server {
namespace {

constexpr int kProbes = 3;
// SIGTERM waits for a probe to end.
constexpr std::chrono::milliseconds kMostPatience{1000};

/// Says once that few file descriptors are left, and again after there were enough in between.
void warn_of_few_descriptors(bool& warned) {
  const FileDescriptors descriptors = file_descriptors();
  const bool few = descriptors.open * 10 >= descriptors.most * 8;
  if (few && !warned) {
    spdlog::warn("{} of {} file descriptors are in use; connections are refused when none is left", descriptors.open,
                 descriptors.most);
  }
  warned = few;
}

}  // namespace

ListenerWatch::ListenerWatch(ListenAddress address, int port, std::chrono::milliseconds interval,
                             std::function<void()> on_deaf)
    : address_(std::move(address)), port_(port), interval_(interval), on_deaf_(std::move(on_deaf)), thread_([this] {
        run();
      }) {}

ListenerWatch::~ListenerWatch() {
  {
    const MutexLock lock(mutex_);
    stopping_ = true;
    stop_requested_.notify_all();
  }
  thread_.join();
}

void ListenerWatch::run() {
  bool warned = false;
  int unanswered = 0;
  while (wait()) {
    switch (look(warned)) {
      case Listener::kAnswers:
        unanswered = 0;
        break;
      case Listener::kUnknown:
        break;
      case Listener::kNone:
      case Listener::kSilent:
        ++unanswered;
        spdlog::warn("the server did not answer a connection of its own, {} in a row", unanswered);
        if (unanswered == kProbes) return on_deaf_();
        break;
    }
  }
}

Listener ListenerWatch::look(bool& warned) {
  const absl::StatusOr<Listener> found = catch_exceptions([&]() -> absl::StatusOr<Listener> {
    warn_of_few_descriptors(warned);
    return probe_listener(address_, port_, std::min(interval_, kMostPatience));
  });
  return found.value_or(Listener::kUnknown);
}

bool ListenerWatch::wait() {
  const auto next = std::chrono::steady_clock::now() + interval_;
  const MutexLock lock(mutex_);
  while (!stopping_ && stop_requested_.wait_until(mutex_, next)) {
  }
  return !stopping_;
}

}  // namespace segserve::server
