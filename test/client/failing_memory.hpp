// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace segserve::client {

/// While it lives, `operator new` throws std::bad_alloc on every thread for blocks of at least `bytes`. One at a time.
class FailingMemory {
 public:
  explicit FailingMemory(std::size_t bytes);
  ~FailingMemory();
  FailingMemory(const FailingMemory&) = delete;
  FailingMemory& operator=(const FailingMemory&) = delete;
};

}  // namespace segserve::client
