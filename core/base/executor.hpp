// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>

#include "absl/functional/function_ref.h"

namespace segserve {

/// Runs the parts of a loop on several threads. The threads come from oneTBB, which keeps them between frames. One
/// thread at a time may use an object.
///
///     Executor executor(4);
///     executor.for_each_range(points, [&](std::size_t begin, std::size_t end) { ... });
class Executor {
 public:
  /// Work is divided into `threads` parts, at least 1. With 1 everything runs on the caller's thread. No more threads
  /// run than there are cores, however many parts there are.
  explicit Executor(unsigned threads);
  ~Executor();
  Executor(Executor&&) noexcept;
  Executor& operator=(Executor&&) noexcept;

  unsigned threads() const { return threads_; }

  /// Calls work(part, begin, end) for threads() contiguous, nearly equal parts of [0, count), and returns when all have
  /// ended. Which thread does which part never changes a result. If a part throws, the exception is thrown here after
  /// all parts that had begun have ended; parts that had not begun are left out.
  template <typename Work>
  void for_each_part(std::size_t count, Work&& work) {
    const auto bound = [&](unsigned part) { return count * part / threads_; };
    if (threads_ == 1) return work(0U, std::size_t{0}, count);
    run_parts([&](unsigned part) { work(part, bound(part), bound(part + 1)); });
  }

  /// Does the same with work(begin, end), which does not need to know its part.
  template <typename Work>
  void for_each_range(std::size_t count, Work&& work) {
    for_each_part(count, [&work](unsigned, std::size_t begin, std::size_t end) { work(begin, end); });
  }

 private:
  struct Arena;

  void run_parts(absl::FunctionRef<void(unsigned part)> run_part);

  unsigned threads_;
  std::unique_ptr<Arena> arena_;  ///< null with one thread
};

}  // namespace segserve
