// SPDX-License-Identifier: Apache-2.0
// Replaces the operators new and delete of the whole program.
#include "test/client/failing_memory.hpp"

#include <atomic>
#include <cstdlib>
#include <limits>
#include <new>

namespace {

constexpr std::size_t kNever = std::numeric_limits<std::size_t>::max();
std::atomic<std::size_t> failing_size{kNever};

}  // namespace

void* operator new(std::size_t size) {
  if (size >= failing_size) throw std::bad_alloc();
  if (void* block = std::malloc(size == 0 ? 1 : size)) return block;
  throw std::bad_alloc();
}

void operator delete(void* block) noexcept { std::free(block); }
void operator delete(void* block, std::size_t /*size*/) noexcept { std::free(block); }

namespace segserve::client {

FailingMemory::FailingMemory(std::size_t bytes) { failing_size = bytes; }
FailingMemory::~FailingMemory() { failing_size = kNever; }

}  // namespace segserve::client
