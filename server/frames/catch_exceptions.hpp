#pragma once

#include <exception>

#include "absl/status/status.h"
#include "spdlog/spdlog.h"

namespace segserve::server {

/// What `function` returns (a Status or StatusOr). An exception, of a library or for want of memory, goes to the log
/// and becomes INTERNAL: it must neither end the server nor leave a call without an answer.
template <typename Function>
auto catch_exceptions(Function&& function) -> decltype(function()) {
  try {
    return function();
  } catch (const std::exception& error) {
    spdlog::error("a call failed with an exception: {}", error.what());
    return absl::InternalError("the server failed to process this call; its log says more");
  }
}

}  // namespace segserve::server
