// SPDX-License-Identifier: Apache-2.0
// Counts what a segmentation allocates. This program replaces the operators new and delete, so the tests of memory have
// a program of their own.
#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <new>
#include <random>
#include <string>
#include <vector>

#include "core/lab/synth/scene.hpp"
#include "gtest/gtest.h"
#include "segserve/segment.hpp"
#include "test/core/support/clouds.hpp"

namespace {

std::atomic<std::int64_t> allocated{0}, most_allocated{0};

void* count(void* block) {
  if (block == nullptr) throw std::bad_alloc();
  const auto now = allocated += static_cast<std::int64_t>(malloc_usable_size(block));
  std::int64_t most = most_allocated;
  while (now > most && !most_allocated.compare_exchange_weak(most, now)) {
  }
  return block;
}

void free_counted(void* block) {
  if (block != nullptr) allocated -= static_cast<std::int64_t>(malloc_usable_size(block));
  std::free(block);
}

}  // namespace

void* operator new(std::size_t size) { return count(std::malloc(std::max<std::size_t>(size, 1))); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  const auto boundary = static_cast<std::size_t>(alignment);
  return count(std::aligned_alloc(boundary, (size + boundary - 1) / boundary * boundary));
}
void operator delete(void* block) noexcept { free_counted(block); }
void operator delete(void* block, std::size_t /*size*/) noexcept { free_counted(block); }
void operator delete(void* block, std::align_val_t /*alignment*/) noexcept { free_counted(block); }
void operator delete(void* block, std::size_t /*size*/, std::align_val_t /*alignment*/) noexcept {
  free_counted(block);
}

namespace segserve {
namespace {

struct Peaks {
  std::int64_t voxelization = 0, afterwards = 0;  // bytes beyond the cloud
  FrameSize size;
};

Peaks peaks_of(const Cloud& cloud, const Options& options) {
  Peaks peaks;
  Segmenter segmenter;
  const std::int64_t before = allocated;
  most_allocated = before;
  std::uint64_t admitted = voxelization_bytes(cloud.size());
  const auto result = segmenter.segment(cloud, options, {}, [&](const FrameSize& size) {
    // The memory that was admitted before must have sufficed until now.
    EXPECT_LE(most_allocated - before, static_cast<std::int64_t>(admitted)) << size.voxels << " voxels so far";
    admitted = std::max(admitted, size.workspace_bytes);
    peaks.size = size;
    peaks.voxelization = most_allocated - before;
    return absl::OkStatus();
  });
  EXPECT_TRUE(result.ok()) << result.status();
  peaks.afterwards = most_allocated - before;
  return peaks;
}

Cloud scattered(std::size_t points, double extent) {
  Cloud cloud = test::unorganized(View::world());
  std::mt19937 random(1);
  const auto coordinate = [&] { return static_cast<float>(extent * (random() / 4294967296.0)); };
  for (std::size_t i = 0; i < points; ++i) {
    const float x = coordinate(), y = coordinate(), z = coordinate();
    test::add(cloud, x, y, z, static_cast<std::uint32_t>(random() & 0xffffffU));
  }
  return cloud;
}

Cloud lattice(int side, float step) {
  Cloud cloud = test::unorganized(View::world());
  for (int i = 0; i < side * side * side; ++i) {
    const auto x = static_cast<float>(i % side), y = static_cast<float>(i / side % side),
               z = static_cast<float>(i / side / side);
    test::add(cloud, step * x, step * y, step * z, 0x808080);
  }
  return cloud;
}

Cloud table_scene() {
  auto scene = synth::make_tabletop({.seed = 3, .width = 320, .height = 240});
  return std::move(scene->cloud);
}

struct Kind {
  std::string name;
  Cloud cloud;
};

std::vector<Kind> kinds() {
  std::vector<Kind> all;
  all.push_back({"lone points", lattice(50, 0.02F)});
  all.push_back({"touching voxels", lattice(50, 0.0075F)});
  all.push_back({"scattered in 1 m", scattered(100'000, 1)});
  all.push_back({"scattered in 100 m", scattered(100'000, 100)});
  all.push_back({"all in one voxel", scattered(100'000, 0.001)});
  all.push_back({"a table", table_scene()});
  return all;
}

TEST(Memory, OfAFrameIsWhatTheAdmissionWasTold) {
  for (const Kind& kind : kinds()) {
    for (const Method method : {Method::kBorder, Method::kLambdaConvex}) {
      const Peaks peaks = peaks_of(kind.cloud, {.method = method});
      const std::uint64_t points = peaks.size.points, voxels = peaks.size.voxels;
      SCOPED_TRACE(kind.name + ", " + std::string(name(method)) + ": " + std::to_string(points) + " points, " +
                   std::to_string(voxels) + " voxels, " +
                   std::to_string(peaks.voxelization / static_cast<double>(points)) + " bytes a point, then " +
                   std::to_string(peaks.afterwards / static_cast<double>(voxels)) + " bytes a voxel");
      EXPECT_LE(peaks.afterwards, peaks.size.workspace_bytes);
    }
  }
}

}  // namespace
}  // namespace segserve
