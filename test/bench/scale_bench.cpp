// How time and memory grow with the number of points, on one core. Run: scale_bench [POINTS ..]
//
// Synthetic tabletops side by side in one unorganised WORLD cloud, by default 100,000 to 10 million points. The
// exponent is that of the power law through the first and the last. Workspace is what was allocated at most, beyond
// input and result; it counts every allocation of the program.
#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <iterator>
#include <new>
#include <numeric>
#include <vector>

#include "fmt/format.h"
#include "segserve/pipeline/segment.hpp"
#include "segserve/synth/scene.hpp"

namespace {

std::atomic<std::int64_t> live_bytes{0}, peak_bytes{0};

}  // namespace

void* operator new(std::size_t bytes) {
  void* memory = std::malloc(bytes);
  if (memory == nullptr) throw std::bad_alloc();
  const std::int64_t live = live_bytes += static_cast<std::int64_t>(malloc_usable_size(memory));
  std::int64_t peak = peak_bytes;
  while (live > peak && !peak_bytes.compare_exchange_weak(peak, live)) {
  }
  return memory;
}

void operator delete(void* memory) noexcept {
  if (memory != nullptr) live_bytes -= static_cast<std::int64_t>(malloc_usable_size(memory));
  std::free(memory);
}

void operator delete(void* memory, std::size_t) noexcept { operator delete(memory); }

namespace segserve::bench {
namespace {

constexpr double kPointsPerSize = 3.75e6;  // of a room of size 1: 2.8 mm apart, eight in a voxel as on an OSD frame
constexpr double kLeastSize = 0.7;
constexpr std::size_t kMostAtOnce = 15'000'000;

/// A room of this many points, or the middle of one that is larger.
Cloud room(std::size_t points) {
  synth::RoomOptions options;
  options.size = std::max(kLeastSize, std::sqrt(static_cast<double>(points) / kPointsPerSize));
  options.points = static_cast<std::uint32_t>(std::lround(kPointsPerSize * options.size * options.size));
  const Cloud all = synth::make_fused_room(options).value().cloud;
  std::vector<std::uint32_t> order(all.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto distance = [&](std::uint32_t i) { return std::max(std::abs(all.x[i]), std::abs(all.y[i])); };
  points = std::min(points, all.size());
  std::ranges::nth_element(order, order.begin() + static_cast<std::ptrdiff_t>(points - 1), {}, distance);
  order.resize(points);
  std::ranges::sort(order);  // the order in which a scanner would give them
  Cloud middle;
  middle.resize(points, true);
  for (std::size_t i = 0; i < points; ++i) {
    middle.x[i] = all.x[order[i]], middle.y[i] = all.y[order[i]], middle.z[i] = all.z[order[i]];
    middle.rgb[i] = all.rgb[order[i]];
  }
  middle.view = all.view;
  return middle;
}

/// One room, or several of kMostAtOnce side by side.
Cloud rooms(std::size_t points) {
  const std::size_t count = (points + kMostAtOnce - 1) / kMostAtOnce;
  const Cloud one = room(points / count);
  const float width = 2 * std::ranges::max(one.x) + 1;
  Cloud all;
  all.view = one.view;
  for (std::size_t r = 0; r < count; ++r) {
    std::ranges::transform(one.x, std::back_inserter(all.x),
                           [&](float x) { return x + width * static_cast<float>(r); });
    all.y.insert(all.y.end(), one.y.begin(), one.y.end());
    all.z.insert(all.z.end(), one.z.begin(), one.z.end());
    all.rgb.insert(all.rgb.end(), one.rgb.begin(), one.rgb.end());
  }
  all.width = static_cast<std::uint32_t>(all.x.size());
  all.height = 1;
  return all;
}

struct Measured {
  std::size_t voxels = 0;
  double ms = 0;               ///< the fastest of three calls
  double workspace_bytes = 0;  ///< of the first call
};

Measured measure(const CloudView& cloud, Method method) {
  Options options;
  options.method = method;
  Segmenter segmenter;
  Measured measured{.voxels = 0, .ms = 1e300, .workspace_bytes = 0};
  for (int call = 0; call < 3; ++call) {
    const std::int64_t before = live_bytes;
    peak_bytes = before;
    const auto start = std::chrono::steady_clock::now();
    const auto result = segmenter.segment(cloud, options);
    const auto end = std::chrono::steady_clock::now();
    if (!result.ok()) {
      fmt::print(stderr, "scale_bench: {}\n", std::string(result.status().message()));
      std::exit(1);
    }
    measured.ms = std::min(measured.ms, std::chrono::duration<double, std::milli>(end - start).count());
    measured.voxels = result->voxels;
    const std::size_t output = 2 * sizeof(std::uint32_t) * cloud.size();
    if (call == 0) measured.workspace_bytes = static_cast<double>(peak_bytes - before) - static_cast<double>(output);
  }
  return measured;
}

void run(Method method, const std::vector<std::size_t>& sizes) {
  fmt::print("| {}, points | voxels | ms | ns a point | workspace, bytes a point |\n| --- | --- | --- | --- | --- |\n",
             name(method));
  std::vector<double> times;
  for (const std::size_t points : sizes) {
    const Cloud cloud = rooms(points);
    const Measured measured = measure(cloud, method);
    const auto n = static_cast<double>(cloud.size());
    fmt::print("| {} | {} | {:.1f} | {:.1f} | {:.0f} |\n", cloud.size(), measured.voxels, measured.ms,
               1e6 * measured.ms / n, measured.workspace_bytes / n);
    std::fflush(stdout);
    times.push_back(measured.ms);
  }
  if (sizes.size() > 1) {
    const double exponent = std::log(times.back() / times.front()) /
                            std::log(static_cast<double>(sizes.back()) / static_cast<double>(sizes.front()));
    fmt::print("\nexponent of the time: {:.2f}\n\n", exponent);
  }
}

}  // namespace
}  // namespace segserve::bench

int main(int argc, char** argv) {
  std::vector<std::size_t> sizes;
  for (int i = 1; i < argc; ++i) sizes.push_back(std::strtoull(argv[i], nullptr, 10));
  if (std::ranges::find(sizes, 0U) != sizes.end()) {
    fmt::print(stderr, "scale_bench: POINTS must be positive numbers\n");
    return 2;
  }
  if (sizes.empty()) sizes = {100'000, 300'000, 1'000'000, 3'000'000, 10'000'000};
  for (const auto method : {segserve::Method::kLambdaConvex, segserve::Method::kBorder}) {
    segserve::bench::run(method, sizes);
  }
}
