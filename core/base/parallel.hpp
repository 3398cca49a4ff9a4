#pragma once

#include <cstddef>
#include <thread>
#include <vector>

namespace segserve {

/// Calls work(part, begin, end) for `threads` contiguous, nearly equal parts of [0, count), each on a
/// thread of its own, the first on the caller's. Which part does what never changes a result.
template <typename Work>
void parallel_parts(std::size_t count, unsigned threads, Work&& work) {
  const auto bound = [&](unsigned part) { return count * part / threads; };
  std::vector<std::jthread> helpers;
  helpers.reserve(threads - 1);
  for (unsigned part = 1; part < threads; ++part) {
    helpers.emplace_back([&work, &bound, part] { work(part, bound(part), bound(part + 1)); });
  }
  work(0U, std::size_t{0}, bound(1));
}

/// As above, without the number of the part.
template <typename Work>
void parallel_ranges(std::size_t count, unsigned threads, Work&& work) {
  parallel_parts(count, threads, [&work](unsigned, std::size_t begin, std::size_t end) { work(begin, end); });
}

}  // namespace segserve
