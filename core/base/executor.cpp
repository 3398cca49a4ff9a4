// SPDX-License-Identifier: Apache-2.0
#include "core/base/executor.hpp"

#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/partitioner.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>

#if defined(SEGSERVE_ANNOTATE_FOR_TSAN)
#include <sanitizer/tsan_interface.h>
#endif

namespace segserve {
namespace {

// Debian's TBB is not built for ThreadSanitizer, which therefore does not see that TBB starts a part after the caller
// and ends it before the caller goes on. These tell it.
#if defined(SEGSERVE_ANNOTATE_FOR_TSAN)
void announce(void* fork_or_join) { __tsan_release(fork_or_join); }
void observe(void* fork_or_join) { __tsan_acquire(fork_or_join); }
#else
void announce(void*) {}
void observe(void*) {}
#endif

}  // namespace

struct Executor::Arena {
  // TBB warns on stderr if it is asked for more threads than there are cores.
  explicit Arena(unsigned threads)
      : tasks(std::min(static_cast<int>(threads), oneapi::tbb::info::default_concurrency())) {}
  oneapi::tbb::task_arena tasks;
};

Executor::Executor(unsigned threads)
    : threads_(std::max(threads, 1U)), arena_(threads_ > 1 ? std::make_unique<Arena>(threads_) : nullptr) {}
Executor::~Executor() = default;
Executor::Executor(Executor&&) noexcept = default;
Executor& Executor::operator=(Executor&&) noexcept = default;

void Executor::run_parts(absl::FunctionRef<void(unsigned part)> run_part) {
  // At the end of a scope, because a part may end by an exception.
  struct Announcement {
    void* of;
    ~Announcement() { announce(of); }
  };
  struct Observation {
    void* of;
    ~Observation() { observe(of); }
  };
  char fork = 0, join = 0;
  announce(&fork);
  const Observation of_all_parts{&join};
  arena_->tasks.execute([&] {
    const auto run = [&](unsigned part) {
      observe(&fork);
      const Announcement of_this_part{&join};
      run_part(part);
    };
    oneapi::tbb::parallel_for(0U, threads_, run, oneapi::tbb::static_partitioner());
  });
}

}  // namespace segserve
