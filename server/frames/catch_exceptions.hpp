// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "absl/status/status.h"
#include "core/base/exception_status.hpp"
#include "spdlog/spdlog.h"

namespace segserve::server {

/// Returns what `function` returns, which is a Status or StatusOr. An exception of a library, or one for lack of
/// memory, goes to the log and becomes INTERNAL: it must neither end the server nor leave a frame without an answer.
/// Lack of memory is INTERNAL, too, because RESOURCE_EXHAUSTED would make clients send the same frame again. Without
/// memory even for that, the status has no message.
template <typename Function>
auto catch_exceptions(Function&& function) noexcept -> decltype(function()) {
  try {
    try {
      return function();
    } catch (...) {
      const absl::Status status = exception_status("process a frame");
      spdlog::error(std::string(status.message()));
    }
    return absl::InternalError("the server failed to process this frame; its log says more");
  } catch (...) {  // the attempt to report it
    return absl::Status(absl::StatusCode::kInternal, "");
  }
}

}  // namespace segserve::server
