// SPDX-License-Identifier: Apache-2.0
#include "core/codec/view/view_choice.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "gmock/gmock.h"

namespace segserve::codec {
namespace {

using testing::HasSubstr;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

void add(Cloud& cloud, float x, float y, float z) {
  cloud.x.push_back(x);
  cloud.y.push_back(y);
  cloud.z.push_back(z);
}

/// A camera's frame of 40 x 30 pixels that sees a slope with a step; `sign` -1 reverses y and z.
Cloud frame(float sign = 1) {
  Cloud cloud;
  cloud.width = 40;
  cloud.height = 30;
  for (int v = 0; v < 30; ++v) {
    for (int u = 0; u < 40; ++u) {
      const float z = 1 + 0.02F * static_cast<float>(v) + (u > 20 ? 0.3F : 0);
      const float x = (static_cast<float>(u) - 19.5F) / 35 * z, y = (static_cast<float>(v) - 14.5F) / 35 * z;
      add(cloud, x, sign * y, sign * z);
    }
  }
  return cloud;
}

/// Returns the points in another order, without rows.
Cloud shuffled(Cloud cloud) {
  std::mt19937 random(5);
  for (std::size_t i = cloud.x.size(); i > 1; --i) {
    const std::size_t k = random() % i;
    std::swap(cloud.x[i - 1], cloud.x[k]);
    std::swap(cloud.y[i - 1], cloud.y[k]);
    std::swap(cloud.z[i - 1], cloud.z[k]);
  }
  cloud.width = static_cast<std::uint32_t>(cloud.x.size());
  cloud.height = 1;
  return cloud;
}

/// A sweep of 8 rings x 60 in a room; ring by ring.
Cloud sweep() {
  Cloud cloud;
  cloud.width = 60;
  cloud.height = 8;
  for (int ring = 0; ring < 8; ++ring) {
    const float elevation = -0.3F + 0.07F * static_cast<float>(ring);
    for (int step = 0; step < 60; ++step) {
      const float angle = 0.104719755F * static_cast<float>(step);
      const float range = 3 + std::sin(3 * angle);
      add(cloud, range * std::cos(angle), range * std::sin(angle), range * elevation);
    }
  }
  return cloud;
}

/// A horizontal grid of points at this height, centered on (x, y), with bumps.
Cloud table(float x, float y, float z) {
  Cloud cloud;
  for (int i = 0; i < 30; ++i) {
    for (int k = 0; k < 30; ++k) {
      const float bump = i > 20 && k > 20 ? 0.1F + 0.001F * static_cast<float>(i) : 0;
      add(cloud, x + 0.03F * static_cast<float>(i - 15), y + 0.03F * static_cast<float>(k - 15), z + bump);
    }
  }
  cloud.width = 900;
  cloud.height = 1;
  return cloud;
}

ViewChoice choose(const Cloud& cloud, const ViewEvidence& evidence = {}) {
  const StopToken never;
  StopCheck check(never);
  return choose_view(cloud, evidence, check).value();
}

ViewEvidence viewpoint(double x, double y, double z) {
  return {.position = Eigen::Vector3d(x, y, z), .entry = "VIEWPOINT", .has_entry = true};
}

bool is_camera(const ViewChoice& choice) { return choice.kind == ViewKind::kCamera; }

TEST(ViewChoice, RowsOfPixelsAreACamera) {
  EXPECT_TRUE(is_camera(choose(frame(), viewpoint(0, 0, 0))));
  EXPECT_TRUE(is_camera(choose(frame())));
  EXPECT_TRUE(is_camera(choose(frame(), viewpoint(0.1, 0, 0.5)))) << "pixels are surer than a number in a header";
  EXPECT_FALSE(choose(frame()).y_and_z_are_reversed);
}

TEST(ViewChoice, AYThatPointsUpIsACameraToo) {
  const ViewChoice choice = choose(frame(-1), viewpoint(0, 0, 0));
  EXPECT_TRUE(is_camera(choice));
  EXPECT_TRUE(choice.y_and_z_are_reversed);
  EXPECT_THAT(choice.rule, HasSubstr("y points up"));
  EXPECT_TRUE(choose(shuffled(frame(-1))).y_and_z_are_reversed);
}

TEST(ViewChoice, ZerosAndNanDoNotMatter) {
  Cloud cloud = frame();
  for (std::size_t i = 0; i < cloud.x.size(); i += 3) cloud.x[i] = cloud.y[i] = cloud.z[i] = i % 2 == 0 ? 0 : kNan;
  EXPECT_TRUE(is_camera(choose(cloud, viewpoint(0, 0, 0))));
}

TEST(ViewChoice, PixelsWithoutRowsAreACamera) {
  EXPECT_TRUE(is_camera(choose(shuffled(frame()))));
  EXPECT_TRUE(is_camera(choose(shuffled(frame()), viewpoint(0, 0, 0))));
}

TEST(ViewChoice, AnOrganizedCloudThatWasMovedIsNoCamera) {
  Cloud cloud = frame();
  for (std::size_t i = 0; i < cloud.x.size(); ++i) {  // z up; the camera is 1 m above the floor and looks along y
    const float x = cloud.x[i], y = cloud.y[i], z = cloud.z[i];
    cloud.x[i] = x, cloud.y[i] = z - 2, cloud.z[i] = 1 - y;
  }
  const ViewChoice choice = choose(cloud, viewpoint(0, 0, 0));
  EXPECT_EQ(choice.kind, ViewKind::kWorld);
  EXPECT_FALSE(choice.sensor);
  EXPECT_EQ(choose(cloud, viewpoint(0, -2, 1)).sensor, Eigen::Vector3d(0, -2, 1));
}

TEST(ViewChoice, SweepsOfALidarAreSeenFromTheOrigin) {
  for (const Cloud& cloud : {sweep(), shuffled(sweep())}) {
    const ViewChoice choice = choose(cloud, viewpoint(0, 0, 0));
    EXPECT_EQ(choice.kind, ViewKind::kWorld);
    EXPECT_EQ(choice.sensor, Eigen::Vector3d(0, 0, 0)) << choice.rule;
    EXPECT_EQ(choose(cloud).sensor, Eigen::Vector3d(0, 0, 0)) << "whatever the format";
  }
}

TEST(ViewChoice, ADefaultPositionIsBelievedOnlyOutside) {
  EXPECT_FALSE(choose(table(0, 0, -0.05F), viewpoint(0, 0, 0)).sensor) << "inside the box";
  EXPECT_FALSE(choose(table(0, 0, 0.7F), viewpoint(0, 0, 0)).sensor) << "below the table";
  EXPECT_FALSE(choose(table(0.7F, 0.7F, 0.3F), viewpoint(0, 0, 0)).sensor) << "below, aside";
  EXPECT_FALSE(choose(table(0.7F, 0.7F, -0.001F), viewpoint(0, 0, 0)).sensor) << "as high as the table";
  EXPECT_EQ(choose(table(0, 3, -1), viewpoint(0, 0, 0)).sensor, Eigen::Vector3d(0, 0, 0)) << "above, aside";
  EXPECT_EQ(choose(table(0.7F, 0, 3), viewpoint(0, 0, 0)).sensor, Eigen::Vector3d(0, 0, 0)) << "in a camera's view";
  EXPECT_FALSE(choose(table(0, 3, -1)).sensor) << "a format that has no entry for it";
  EXPECT_EQ(choose(table(0, 0, 0), viewpoint(0, 0, 2)).sensor, Eigen::Vector3d(0, 0, 2));
}

/// Heights on a raster of 50 x 40 points, z up, all above 0.
Cloud raster() {
  Cloud cloud;
  cloud.width = 50;
  cloud.height = 40;
  for (int v = 0; v < 40; ++v) {
    for (int u = 0; u < 50; ++u) {
      const bool box = u > 20 && u < 35 && v > 10 && v < 25;
      add(cloud, 0.01F * static_cast<float>(u - 25), 0.01F * static_cast<float>(v - 20), box ? 1.25F : 1.0F);
    }
  }
  return cloud;
}

/// The inner surfaces of a room of 5 m x 4 m x 2.5 m, and a box in it. Its corner is at the origin, moved aside.
Cloud room(float aside_x = 0, float aside_y = 0) {
  Cloud cloud;
  std::mt19937 random(3);
  const auto share = [&random] { return static_cast<float>(random() % 100'000) / 100'000; };
  const auto add_box = [&](float x, float y, float width, float depth, float height, int points) {
    for (int i = 0; i < points; ++i) {
      std::array<float, 3> p{share(), share(), share()};
      p[random() % 3] = random() % 2 == 0 ? 0.0F : 1.0F;
      add(cloud, aside_x + x + width * p[0], aside_y + y + depth * p[1], height * p[2]);
    }
  };
  add_box(0, 0, 5, 4, 2.5F, 60'000);
  add_box(2, 1, 0.6F, 0.6F, 1, 4'000);
  cloud.width = static_cast<std::uint32_t>(cloud.x.size());
  cloud.height = 1;
  return cloud;
}

TEST(ViewChoice, ARoomWithItsCornerAtTheOriginIsNoSweep) { EXPECT_FALSE(choose(room()).sensor); }

TEST(ViewChoice, WhereThePointsHideOneAnotherIsNoSensor) {
  const ViewChoice aside = choose(room(2, -9), viewpoint(0, 0, 0));
  EXPECT_FALSE(aside.sensor);
  EXPECT_THAT(aside.rule, HasSubstr("hide one another"));
  // A sensor there sees the floor, and two walls behind it.
  Cloud seen;
  const Cloud all = room(2, -9);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool is_far_wall = all.y[i] < -8.999F || all.x[i] > 6.999F;
    if (is_far_wall || all.z[i] < 0.001F) add(seen, all.x[i], all.y[i], all.z[i] - 1);
  }
  seen.width = static_cast<std::uint32_t>(seen.x.size());
  seen.height = 1;
  EXPECT_EQ(choose(seen, viewpoint(0, 0, 0)).sensor, Eigen::Vector3d(0, 0, 0));
}

/// The surface of a cube of edge 1 around the origin, or the three sides of it that face -(1, 1, 1).
Cloud cube(bool is_closed, int points) {
  Cloud cloud;
  std::mt19937 random(7);
  const auto share = [&random] { return static_cast<float>(random() % 100'000) / 100'000 - 0.5F; };
  for (int i = 0; i < points; ++i) {
    std::array<float, 3> p{share(), share(), share()};
    p[random() % 3] = is_closed && random() % 2 == 0 ? 0.5F : -0.5F;
    add(cloud, p[0], p[1], p[2]);
  }
  cloud.width = static_cast<std::uint32_t>(cloud.x.size());
  cloud.height = 1;
  return cloud;
}

Cloud moved(Cloud cloud, float scale, float x, float y, float z) {
  for (float& v : cloud.x) v = scale * v + x;
  for (float& v : cloud.y) v = scale * v + y;
  for (float& v : cloud.z) v = scale * v + z;
  return cloud;
}

TEST(ViewChoice, AClosedSurfaceWasNotSeenFromOnePlace) {
  for (const int points : {6'000, 60'000}) {
    for (const float scale : {0.1F, 1.0F}) {
      for (const auto& [x, y, z] : std::vector<std::array<float, 3>>{{0, 0, 3}, {2, 2, 2}, {0.2F, 3, -1}, {5, 0, -5}}) {
        const Cloud closed = moved(cube(true, points), scale, x, y, z);
        const ViewChoice choice = choose(closed, viewpoint(0, 0, 0));
        EXPECT_FALSE(choice.sensor) << points << " points, size " << scale << ", at " << x << " " << y << " " << z;
        EXPECT_EQ(choose(closed, viewpoint(0, 0, 1)).sensor, Eigen::Vector3d(0, 0, 1)) << "a position is believed";
      }
      const Cloud open = moved(cube(false, points), -scale, -2 * scale, -2 * scale, -2 * scale);
      EXPECT_TRUE(choose(open, viewpoint(0, 0, 0)).sensor) << points << " points, size " << scale;
    }
  }
}

TEST(ViewChoice, ARasterOfHeightsIsNoCamera) {
  EXPECT_EQ(choose(raster()).kind, ViewKind::kWorld);
  EXPECT_EQ(choose(shuffled(raster())).kind, ViewKind::kWorld);
}

TEST(ViewChoice, ABodyOfRevolutionIsNoSweep) {
  Cloud cylinder;
  for (int ring = 0; ring < 20; ++ring) {
    for (int step = 0; step < 60; ++step) {
      const float angle = 0.104719755F * static_cast<float>(step);
      add(cylinder, std::cos(angle), std::sin(angle), 0.1F * static_cast<float>(ring - 10));
    }
  }
  cylinder.width = 1200;
  cylinder.height = 1;
  EXPECT_FALSE(choose(cylinder).sensor) << choose(cylinder).rule;
}

TEST(ViewChoice, NoSensorIsFarFromWhatItSaw) {
  Cloud cloud = table(0, 0, 0);
  for (float& x : cloud.x) x += 1000;
  EXPECT_FALSE(choose(cloud, viewpoint(0, 0, 0)).sensor);
}

TEST(ViewChoice, AFrameWithoutAnyDepthIsACameras) {
  Cloud cloud;
  cloud.x = cloud.y = cloud.z = std::vector<float>(12, 0);
  cloud.width = 4;
  cloud.height = 3;
  EXPECT_TRUE(is_camera(choose(cloud, viewpoint(0, 0, 0))));
}

TEST(ViewChoice, WhatIsGivenOrStatedWins) {
  ViewEvidence evidence = viewpoint(0, 0, 2);
  evidence.stated = View::world();
  EXPECT_FALSE(choose(frame(), evidence).sensor);
  EXPECT_EQ(choose(frame(), evidence).rule, "WORLD, as the file says");
  evidence.given = View::camera();
  EXPECT_EQ(choose(frame(), evidence).rule, "CAMERA, as asked for");
  EXPECT_TRUE(choose(frame(-1), evidence).y_and_z_are_reversed);
}

TEST(ViewChoice, DoesNotDependOnTheOrderOfPoints) {
  const ViewChoice one = choose(shuffled(frame())), other = choose(shuffled(shuffled(frame())));
  EXPECT_EQ(one.rule, other.rule);
}

TEST(ViewChoice, HearsToStop) {
  const std::atomic<bool> cancelled{true};
  const StopToken stop(&cancelled);
  StopCheck check(stop);
  Cloud many = shuffled(frame());
  for (int i = 0; i < 4; ++i) {
    many.x.insert(many.x.end(), many.x.begin(), many.x.end());
    many.y.insert(many.y.end(), many.y.begin(), many.y.end());
    many.z.insert(many.z.end(), many.z.begin(), many.z.end());
  }
  many.width = static_cast<std::uint32_t>(many.x.size());
  EXPECT_EQ(choose_view(many, {}, check).status().code(), absl::StatusCode::kCancelled);
}

TEST(ViewStatement, ReadsBackWhatItWrote) {
  for (const View& view : {View::camera(), View::world(), View::world(0.1F, -2, 1e6F)}) {
    EXPECT_EQ(stated_view(view_statement(view)), view) << view_statement(view);
  }
  for (const char* other : {"", "written by segserve", "segserve view", "segserve view world 1 2", "segserve view moon",
                            "segserve view world 1 2 nan", "segserve view camera 1"}) {
    EXPECT_FALSE(stated_view(other)) << other;
  }
}

}  // namespace
}  // namespace segserve::codec
