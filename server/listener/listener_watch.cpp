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
  const bool few = descriptors.open * 10 >= descriptors.limit * 8;
  if (few && !warned) {
    spdlog::warn("{} of {} file descriptors are in use; connections are refused when none is left", descriptors.open,
                 descriptors.limit);
  }
  warned = few;
}

}  // namespace

ListenerWatch::ListenerWatch(ListenAddress address, int port, std::chrono::milliseconds interval,
                             std::function<void()> on_deaf)
    : address_(std::move(address)),
      port_(port),
      patience_(std::min(interval, kMostPatience)),
      on_deaf_(std::move(on_deaf)),
      ticker_(interval, [this] { return tick(); }) {}

bool ListenerWatch::tick() {
  const Listener found = look();
  if (found == Listener::kUnknown) return true;
  unanswered_ = found == Listener::kAnswers ? 0 : unanswered_ + 1;
  if (unanswered_ == 0) return true;
  spdlog::warn("the server did not answer a connection of its own, {} in a row", unanswered_);
  if (unanswered_ < kProbes) return true;
  on_deaf_();
  return false;
}

Listener ListenerWatch::look() {
  const absl::StatusOr<Listener> found =
      catch_exceptions("connect to its own listener", [&]() -> absl::StatusOr<Listener> {
        warn_of_few_descriptors(warned_);
        return probe_listener(address_, port_, patience_);
      });
  return found.value_or(Listener::kUnknown);
}

}  // namespace segserve::server
