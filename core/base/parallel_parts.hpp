// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "absl/status/status.h"
#include "core/base/executor.hpp"
#include "core/base/stop_check.hpp"
#include "segserve/stop_token.hpp"

namespace segserve {

/// Calls work(part, begin, end, check) for the parts of [0, count) as Executor::for_each_part does, each with a
/// StopCheck of its own, which the part must report its work to. Returns OK, CANCELLED or DEADLINE_EXCEEDED.
template <typename Work>
absl::Status parallel_parts(Executor& executor, const StopToken& stop, std::size_t count, Work&& work) {
  executor.for_each_part(count, [&](unsigned part, std::size_t begin, std::size_t end) {
    StopCheck check(stop, executor.threads());
    work(part, begin, end, check);
  });
  return stop.check();
}

}  // namespace segserve
