// SPDX-License-Identifier: Apache-2.0
// Measures how time and memory grow with the number of points, on one core. Run: scale_bench [--density D] [POINTS ...]
//
// The clouds are fused rooms in one unorganized WORLD cloud, by default with 100,000 to 10 million points; 30000000 is
// worth a run, too. D is the approximate number of points per voxel. Its default is 8.4, as in OSD frames with default
// voxels (199,001 finite points in 23,788 voxels of learn5). With a smaller D the time depends mostly on the number of
// voxels, with a larger D on the number of points. The printed exponent is that of the power law through the first size
// of at least 300,000 points and the last size.
//
// The first call of a Segmenter is cold: its memory comes from the system. Later calls are warm, and the fastest of
// three counts. The workspace is the peak of memory that the first call allocated, without input and result; every
// allocation of the program is counted.
#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <new>
#include <numeric>
#include <string_view>
#include <utility>
#include <vector>

#include "core/lab/synth/scene.hpp"
#include "fmt/format.h"
#include "segserve/segment.hpp"

namespace {

std::atomic<std::int64_t> live_bytes{0}, peak_bytes{0};

void* counted(void* memory) {
  if (memory == nullptr) throw std::bad_alloc();
  const std::int64_t live = live_bytes += static_cast<std::int64_t>(malloc_usable_size(memory));
  std::int64_t peak = peak_bytes;
  while (live > peak && !peak_bytes.compare_exchange_weak(peak, live)) {
  }
  return memory;
}

}  // namespace

void* operator new(std::size_t bytes) { return counted(std::malloc(bytes)); }

void* operator new(std::size_t bytes, std::align_val_t alignment) {
  const auto unit = static_cast<std::size_t>(alignment);
  return counted(std::aligned_alloc(unit, (bytes + unit - 1) / unit * unit));
}

void operator delete(void* memory) noexcept {
  if (memory != nullptr) live_bytes -= static_cast<std::int64_t>(malloc_usable_size(memory));
  std::free(memory);
}

void operator delete(void* memory, std::size_t) noexcept { operator delete(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { operator delete(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { operator delete(memory); }

namespace segserve::bench {
namespace {

constexpr double kUsualDensity = 8.4;
constexpr double kRoomSize = 0.7;
constexpr double kRoomVoxels =
    297e3;  // of lambda-convex; nearly independent of the number of points from 1.8 to 3.7 million on

/// A room with `density` points per voxel.
Cloud whole_room(double density) {
  synth::RoomOptions options;
  options.size = kRoomSize;
  options.points = static_cast<std::uint32_t>(std::lround(kRoomVoxels * density));
  auto scene = synth::make_fused_room(options);
  if (!scene.ok()) {
    fmt::print(stderr, "scale_bench: {}\n", std::string(scene.status().message()));
    std::exit(2);
  }
  return std::move(scene->cloud);
}

/// The indices of `points` points in four sectors of a room, from its middle to its walls, so that they have the same
/// mix of surfaces as the room. They are in the order in which a scanner would give them.
std::vector<std::uint32_t> sectors(const Cloud& room, std::size_t points) {
  constexpr float kTurn = 6.2831853F;
  std::vector<std::uint32_t> order(room.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto angle = [&](std::uint32_t i) { return std::fmod(std::atan2(room.y[i], room.x[i]) + kTurn, kTurn / 4); };
  std::ranges::nth_element(order, order.begin() + static_cast<std::ptrdiff_t>(points - 1), {}, angle);
  order.resize(points);
  std::ranges::sort(order);
  return order;
}

/// As many rooms side by side as needed, so that clouds of every size have the same mix of surfaces and the same
/// density.
Cloud rooms(const Cloud& room, std::size_t points) {
  const std::size_t count = (points + room.size() - 1) / room.size();
  const std::vector<std::uint32_t> taken = sectors(room, points / count);
  const float width = 2 * std::ranges::max(room.x) + 1;
  Cloud all;
  all.view = room.view;
  all.resize(count * taken.size(), true);
  std::size_t at = 0;
  for (std::size_t r = 0; r < count; ++r) {
    for (const std::uint32_t i : taken) {
      all.x[at] = room.x[i] + width * static_cast<float>(r);
      all.y[at] = room.y[i], all.z[at] = room.z[i], all.rgb[at] = room.rgb[i];
      ++at;
    }
  }
  all.width = static_cast<std::uint32_t>(all.size());
  all.height = 1;
  return all;
}

struct Measured {
  std::size_t voxels = 0;
  double cold_ms = 0;
  StageTimings warm;
  double workspace_bytes = 0;
};

Measured measure(const CloudView& cloud, Method method) {
  constexpr int kCalls = 4;
  Options options;
  options.method = method;
  Segmenter segmenter;
  Measured measured;
  for (int call = 0; call < kCalls; ++call) {
    const std::int64_t before = live_bytes;
    peak_bytes = before;
    const auto result = segmenter.segment(cloud, options);
    if (!result.ok()) {
      fmt::print(stderr, "scale_bench: {}\n", std::string(result.status().message()));
      std::exit(1);
    }
    const StageTimings& timings = result->timings;
    if (call == 0) {
      const std::size_t output = 2 * sizeof(std::uint32_t) * cloud.size();
      measured.workspace_bytes = static_cast<double>(peak_bytes - before) - static_cast<double>(output);
      measured.cold_ms = timings.total;
    } else if (call == 1 || timings.total < measured.warm.total) {
      measured.warm = timings;
    }
    measured.voxels = result->voxels;
  }
  return measured;
}

void run(Method method, const std::vector<Cloud>& clouds) {
  fmt::print(
      "| {}, points | a voxel | voxels | normals | supervoxels | graph | merging | labels | ms | ns a point | cold ms "
      "| "
      "workspace, bytes a point |\n",
      name(method));
  fmt::print("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
  constexpr std::size_t kLeastOfExponent = 300'000;  // Smaller clouds fit into the caches.
  std::vector<std::pair<double, double>> logarithms;
  for (const Cloud& cloud : clouds) {
    const Measured m = measure(cloud, method);
    const auto n = static_cast<double>(cloud.size());
    fmt::print(
        "| {} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.0f} |\n",
        cloud.size(), n / static_cast<double>(m.voxels), m.warm.voxels, m.warm.normals, m.warm.supervoxels,
        m.warm.graph, m.warm.merging, m.warm.labels, m.warm.total, 1e6 * m.warm.total / n, m.cold_ms,
        m.workspace_bytes / n);
    std::fflush(stdout);
    if (cloud.size() >= kLeastOfExponent) logarithms.emplace_back(std::log(n), std::log(m.warm.total));
  }
  if (logarithms.size() > 1) {
    const auto [n0, t0] = logarithms.front();
    const auto [n1, t1] = logarithms.back();
    fmt::print("\nexponent of the time: {:.2f}\n\n", (t1 - t0) / (n1 - n0));
  }
}

/// Returns false if the text is not a positive number.
template <typename Number>
bool read(std::string_view text, Number& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() && number > 0;
}

}  // namespace
}  // namespace segserve::bench

int main(int argc, char** argv) {
  // As in segserve, memory that one stage frees is kept for the next.
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
  double density = segserve::bench::kUsualDensity;
  std::vector<std::size_t> sizes;
  for (int i = 1; i < argc; ++i) {
    const bool is_density = std::string_view(argv[i]) == "--density";
    if (is_density ? ++i == argc || !segserve::bench::read(argv[i], density)
                   : !segserve::bench::read(argv[i], sizes.emplace_back())) {
      fmt::print(stderr, "usage: scale_bench [--density POINTS_A_VOXEL] [POINTS ...], positive numbers\n");
      return 2;
    }
  }
  if (sizes.empty()) sizes = {100'000, 300'000, 1'000'000, 3'000'000, 10'000'000};
  const segserve::Cloud room = segserve::bench::whole_room(density);
  std::vector<segserve::Cloud> clouds;
  clouds.reserve(sizes.size());
  for (const std::size_t points : sizes) clouds.push_back(segserve::bench::rooms(room, points));
  for (const auto method : {segserve::Method::kLambdaConvex, segserve::Method::kBorder}) {
    segserve::bench::run(method, clouds);
  }
}
