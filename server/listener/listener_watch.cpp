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

ListenerWatch::ListenerWatch(const std::vector<WatchedListener>& listeners, std::chrono::milliseconds interval,
                             std::function<void()> on_deaf)
    : patience_(std::min(interval, kMostPatience)),
      on_deaf_(std::move(on_deaf)),
      listeners_(watched(listeners)),
      ticker_(interval, [this] { return tick(); }) {}

std::vector<ListenerWatch::Watched> ListenerWatch::watched(const std::vector<WatchedListener>& listeners) {
  std::vector<Watched> all;
  for (const WatchedListener& each : listeners) {
    all.push_back({.name = with_port(each.address, each.port),
                   .probe = ListenerProbe(each.address, each.port),
                   .accepted = each.accepted,
                   .accepted_before = each.accepted ? each.accepted() : 0});
  }
  return all;
}

bool ListenerWatch::tick() {
  const absl::StatusOr<bool> any_deaf =
      catch_exceptions("connect to its own listeners", [this]() -> absl::StatusOr<bool> {
        warn_of_few_descriptors(warned_);
        return std::ranges::any_of(listeners_, [this](Watched& each) { return is_deaf(each); });
      });
  // Without memory for a probe nothing is known.
  if (!any_deaf.value_or(false)) return true;
  on_deaf_();
  return false;
}

bool ListenerWatch::is_deaf(Watched& listener) const {
  const Listener found = listener.probe.look(patience_);
  const bool lives = has_accepted(listener) || found == Listener::kAnswers;
  if (found == Listener::kUnknown) return false;
  listener.unanswered = lives ? 0 : listener.unanswered + 1;
  if (listener.unanswered == 0) return false;
  spdlog::warn("the server did not answer a connection of its own to {}, {} in a row", listener.name,
               listener.unanswered);
  return listener.unanswered >= kProbes;
}

bool ListenerWatch::has_accepted(Watched& listener) {
  if (!listener.accepted) return false;
  const std::uint64_t now = listener.accepted();
  return std::exchange(listener.accepted_before, now) != now;
}

}  // namespace segserve::server
