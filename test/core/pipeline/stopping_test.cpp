// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <random>
#include <string>

#include "gmock/gmock.h"
#include "segserve/options.hpp"
#include "segserve/segment.hpp"
#include "test/core/support/clouds.hpp"

namespace segserve {
namespace {

/// An organized cloud: a wavy colored surface with steps, seen from the camera.
Cloud camera_image(std::uint32_t width, std::uint32_t height) {
  Cloud cloud;
  cloud.view = View::camera();
  cloud.resize(std::size_t{width} * height, true);
  cloud.width = width;
  cloud.height = height;
  std::mt19937 random(3);
  for (std::uint32_t i = 0; i < cloud.size(); ++i) {
    const std::uint32_t u = i % width, v = i / width;
    const float step = (u / 97 + v / 61) % 3 == 0 ? 0.15F : 0.0F;
    const float z =
        1.0F + step + 0.0004F * static_cast<float>((u * v) % 499) + 0.001F * static_cast<float>(random() % 3);
    cloud.x[i] = z * (static_cast<float>(u) / static_cast<float>(width) - 0.5F);
    cloud.y[i] = z * (static_cast<float>(v) / static_cast<float>(width) - 0.4F);
    cloud.z[i] = z;
    cloud.rgb[i] = (u / 50 * 0x203040U + v / 70 * 0x102030U) & 0xffffffU;
  }
  return cloud;
}

/// Returns the points without rows, in random order.
Cloud shuffled(const Cloud& image, View view) {
  std::vector<std::uint32_t> order(image.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  std::shuffle(order.begin(), order.end(), std::mt19937(5));
  Cloud cloud = test::permuted(image, order);
  cloud.view = view;
  return cloud;
}

struct Run {
  absl::Status status;
  std::uint64_t looks = 0, units = 0;
  std::uint64_t units_after_stop = 0;
};

/// Segments the cloud, and asks for a stop just after the n-th look at the token, which is the worst moment. With n = 0
/// it does not ask for a stop.
Run run(const Cloud& cloud, const Options& options, std::uint64_t n) {
  std::atomic<bool> cancelled = false;
  std::atomic<std::uint64_t> looks = 0, units_at_stop = 0;
  WorkMeter meter([&](std::uint64_t) {
    if (++looks != n) return;
    cancelled = true;
    // Only what comes after the flag counts: where the CPU is taken from this thread before it has set the flag, the
    // other threads go on for as long, because nobody has asked them to stop.
    units_at_stop = meter.units();
  });
  const auto result = segment(cloud, options, StopToken(&cancelled, std::nullopt, &meter));
  return {result.status(), looks, meter.units(), cancelled ? meter.units() - units_at_stop : 0};
}

void expect_stops_soon(const Cloud& cloud, const Options& options, std::uint64_t moments, const std::string& what) {
  const Run whole = run(cloud, options, 0);
  ASSERT_TRUE(whole.status.ok()) << what << whole.status;
  EXPECT_GT(whole.units, 3 * cloud.size())
      << what << ": every point becomes part of a voxel, a supervoxel and a segment";
  ASSERT_GT(whole.looks, moments) << what;
  for (std::uint64_t i = 0; i < moments; ++i) {
    // The very last looks are left out, because the segmentation may be complete by then.
    const std::uint64_t n = 1 + i * (whole.looks - 1) / moments;
    const Run stopped = run(cloud, options, n);
    EXPECT_EQ(stopped.status.code(), absl::StatusCode::kCancelled) << what << ", look " << n << " of " << whole.looks;
    EXPECT_LE(stopped.units_after_stop, StopToken::kMostWorkAfterStop)
        << what << ", look " << n << " of " << whole.looks;
  }
}

TEST(WorkAfterStop, IsBoundedForEveryMethodViewAndNumberOfThreads) {
  const Cloud image = camera_image(240, 160);
  const std::pair<std::string, Cloud> clouds[] = {{"organized", image},
                                                  {"unorganized", shuffled(image, View::world(0, 0, 0))},
                                                  {"without sensor", shuffled(image, View::world())}};
  for (const auto& [kind, cloud] : clouds) {
    for (const Method method : all_methods()) {
      for (const std::uint32_t threads : {1U, 2U}) {
        expect_stops_soon(cloud, {.method = method, .threads = threads}, 4,
                          kind + ", " + std::string(name(method)) + ", threads " + std::to_string(threads));
      }
    }
  }
}

TEST(WorkAfterStop, IsBoundedAtManyMomentsOfOneFrame) {
  expect_stops_soon(camera_image(320, 240), {.min_segment_points = 50}, 40, "one frame");
}

TEST(WorkAfterStop, IsBoundedWhileTheSupportPlaneIsRemoved) {
  expect_stops_soon(camera_image(320, 240), {.support_plane_distance = 0.2}, 25, "support plane");
}

TEST(WorkAfterStop, IsBoundedForManyThreads) {
  for (const std::uint32_t threads : {5U, 16U}) {
    expect_stops_soon(camera_image(400, 300), {.threads = threads}, 5, std::to_string(threads) + " threads");
  }
}

TEST(WorkAfterStop, IsBoundedWhereEveryPointIsASupervoxel) {
  const Cloud scattered = test::random_cloud(60'000, 45, 0, View::world(0, 0, 0));
  expect_stops_soon(scattered, {}, 12, "scattered");
  expect_stops_soon(scattered, {.method = Method::kEqualization, .regions = 10}, 12, "scattered");
}

TEST(WorkAfterStop, IsBoundedWhereASupervoxelIsHuge) {
  expect_stops_soon(camera_image(640, 480), {.voxel_resolution = 0.001, .seed_resolution = 1.0}, 20,
                    "huge supervoxels");
}

TEST(WorkAfterStop, IsBoundedForTwoMillionPoints) {
  expect_stops_soon(camera_image(2000, 1000), {.threads = 2}, 6, "2 million points");
}

TEST(WorkAfterStop, IsBoundedAfterTheDeadlineAsWell) {
  const Cloud cloud = camera_image(320, 240);
  WorkMeter meter;
  const StopToken late(nullptr, StopToken::Clock::now() - std::chrono::seconds(1), &meter);
  EXPECT_EQ(segment(cloud, {}, late).status().code(), absl::StatusCode::kDeadlineExceeded);
  EXPECT_LE(meter.units(), StopToken::kMostWorkAfterStop);
}

TEST(WorkMeter, CountsTheSameForAnyNumberOfThreadsExceptForMergingParts) {
  const Cloud cloud = camera_image(320, 240);
  const std::uint64_t one = run(cloud, {}, 0).units;
  EXPECT_EQ(run(cloud, {}, 0).units, one);
  const std::uint64_t two = run(cloud, {.threads = 2}, 0).units;
  EXPECT_GE(two, one);
  EXPECT_LE(two, one + cloud.size());
}

}  // namespace
}  // namespace segserve
