// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <exception>

#include "absl/status/status.h"
#include "spdlog/spdlog.h"

namespace segserve::server {

/// Returns what `function` returns, which is a Status or StatusOr. An exception of a library, or one for lack of
/// memory, goes to the log and becomes INTERNAL: it must neither end the server nor leave a frame without an answer.
/// Lack of memory is INTERNAL, too, because RESOURCE_EXHAUSTED would make clients send the same frame again.
template <typename Function>
auto catch_exceptions(Function&& function) -> decltype(function()) {
  try {
    return function();
  } catch (const std::exception& error) {
    spdlog::error("a frame failed with an exception: {}", error.what());
  } catch (...) {
    spdlog::error("a frame failed with an exception of an unknown type");
  }
  return absl::InternalError("the server failed to process this frame; its log says more");
}

}  // namespace segserve::server
