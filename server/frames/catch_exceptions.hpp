// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "core/base/exception_status.hpp"
#include "fmt/format.h"
#include "spdlog/spdlog.h"

namespace segserve::server {

/// Returns what `function` returns, which is a Status or StatusOr. An exception of a library, or one for lack of
/// memory, goes to the log and becomes INTERNAL: it must neither end the server nor leave a frame without an answer.
/// Lack of memory is INTERNAL, too, because RESOURCE_EXHAUSTED would make clients send the same frame again. Without
/// memory even for that, the status has no message.
/// `work` completes the sentence "The server failed to ...".
template <typename Function>
auto catch_exceptions(std::string_view work, Function&& function) noexcept -> decltype(function()) {
  try {
    try {
      return function();
    } catch (...) {
      const absl::Status status = exception_status(work);
      spdlog::error(std::string(status.message()));
    }
    return absl::InternalError(fmt::format("the server failed to {}; its log says more", work));
  } catch (...) {  // the attempt to report it
    return absl::Status(absl::StatusCode::kInternal, "");
  }
}

}  // namespace segserve::server
