// SPDX-License-Identifier: Apache-2.0
#include "server/observe/service_observer.hpp"

#include <string_view>

#include "absl/status/status.h"
#include "server/frames/catch_exceptions.hpp"

namespace segserve::server {
namespace {

/// Calls `tell` with each observer.
template <typename Tell>
void tell_all(const std::vector<std::shared_ptr<ServiceObserver>>& observers, std::string_view what,
              const Tell& tell) noexcept {
  for (const auto& observer : observers) {
    const absl::Status told = catch_exceptions(what, [&] {
      tell(*observer);
      return absl::OkStatus();
    });
    told.IgnoreError();  // it is in the log
  }
}

}  // namespace

void ServiceObservers::on_frame(const FrameRecord& frame) const noexcept {
  tell_all(observers_, "tell what became of a frame", [&frame](ServiceObserver& each) { each.on_frame(frame); });
}

void ServiceObservers::on_stream(const StreamRecord& stream) const noexcept {
  tell_all(observers_, "tell what became of a stream", [&stream](ServiceObserver& each) { each.on_stream(stream); });
}

void ServiceObservers::on_refused_question(const RefusedQuestion& question) const noexcept {
  tell_all(observers_, "tell of a refused question",
           [&question](ServiceObserver& each) { each.on_refused_question(question); });
}

}  // namespace segserve::server
