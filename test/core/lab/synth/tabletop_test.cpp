// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "core/lab/synth/scene.hpp"
#include "core/math/vec3.hpp"
#include "test/core/lab/synth/checksum.hpp"

namespace segserve::synth {
namespace {

using testing::AllOf;
using testing::HasSubstr;

SyntheticScene make(const SceneOptions& options) {
  auto scene = make_tabletop(options);
  EXPECT_TRUE(scene.ok()) << scene.status();
  return *std::move(scene);
}

std::map<std::uint32_t, std::size_t> count(const SyntheticScene& scene) {
  std::map<std::uint32_t, std::size_t> result;
  for (const std::uint32_t label : scene.label) ++result[label];
  return result;
}

// The same options give the same bytes on every machine and with every compiler. A change of these
// numbers changes every scene that somebody made before: say so in the changelog.
TEST(TabletopTest, GoldenChecksum) {
  EXPECT_EQ(checksum(make({})), 8732196009040106558U);
  EXPECT_EQ(checksum(make({.seed = 2, .width = 320, .height = 240, .objects = 20, .stacked = 0.5, .clutter = 1})),
            9921562148375703603U);
  EXPECT_EQ(checksum(make({.seed = 3, .noise = 0, .all_finite = true})), 10371578937947642706U);
}

TEST(TabletopTest, TheSeedChangesTheScene) {
  EXPECT_NE(checksum(make({.seed = 1, .width = 64, .height = 48})),
            checksum(make({.seed = 2, .width = 64, .height = 48})));
}

class TabletopSeedTest : public testing::TestWithParam<std::uint64_t> {};

TEST_P(TabletopSeedTest, IsAFrameOfOrganizedPointsWithLabels) {
  const SyntheticScene scene = make({.seed = GetParam(), .objects = 10});
  const Cloud& cloud = scene.cloud;
  EXPECT_EQ(cloud.width, 640U);
  EXPECT_EQ(cloud.height, 480U);
  EXPECT_EQ(cloud.view, View::camera());
  EXPECT_TRUE(check_shape(cloud).ok());
  std::size_t finite = 0;
  for (std::uint32_t v = 0, i = 0; v < 480; ++v) {
    for (std::uint32_t u = 0; u < 640; ++u, ++i) {
      const bool is = is_finite(cloud.x[i], cloud.y[i], cloud.z[i]);
      ASSERT_EQ(is, scene.label[i] != 0);
      if (!is) continue;
      ++finite;
      ASSERT_GT(cloud.z[i], 0.3F);
      ASSERT_LT(cloud.z[i], 4.0F);
      ASSERT_NEAR(cloud.x[i], cloud.z[i] * (u - 319.5) / 525, 1e-5);
      ASSERT_NEAR(cloud.y[i], cloud.z[i] * (v - 239.5) / 525, 1e-5);
    }
  }
  EXPECT_GT(finite, 120000U);
  EXPECT_LT(finite, 300000U);
}

TEST_P(TabletopSeedTest, LabelsAreThoseOfOsd) {
  const auto labels = count(make({.seed = GetParam(), .objects = 10}));
  std::size_t objects = 0;
  for (const auto& [label, points] : labels) {
    EXPECT_TRUE(label <= 1 || label >= 20) << label;
    if (label < 20) continue;
    EXPECT_LT(label, 120U);
    objects += label % 10 == 0 ? 1 : 0;
    EXPECT_TRUE(label % 10 == 0 || labels.count(label - 1) == 1) << label;
  }
  EXPECT_GE(objects, 7U);
  EXPECT_GT(labels.at(1), 100000U);
}

TEST_P(TabletopSeedTest, AllFiniteFillsEveryPixel) {
  for (const auto& [width, height] : {std::pair{640U, 480U}, {16U, 400U}, {400U, 16U}}) {
    const SyntheticScene scene =
        make({.seed = GetParam(), .width = width, .height = height, .distance = 2, .all_finite = true});
    EXPECT_EQ(std::count(scene.label.begin(), scene.label.end(), 0U), 0);
    for (std::size_t i = 0; i < scene.cloud.size(); ++i) {
      ASSERT_TRUE(is_finite(scene.cloud.x[i], scene.cloud.y[i], scene.cloud.z[i]));
      ASSERT_GT(scene.cloud.z[i], 0);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, TabletopSeedTest, testing::Range<std::uint64_t>(1, 9));

TEST(TabletopTest, HollowObjectsAndOtherSensorsHaveGoldenChecksums) {
  EXPECT_EQ(checksum(make({.seed = 4, .width = 320, .height = 240, .hollow = true})), 15698853372988935496U);
  EXPECT_EQ(checksum(make({.seed = 5, .width = 320, .height = 240, .sensor = Sensor::kTimeOfFlight})),
            9626996302678632390U);
}

// Without noise the table is a plane: three of its points give it, all others lie in it.
TEST(TabletopTest, WithoutNoiseTheTableIsFlat) {
  const SyntheticScene scene = make({.objects = 0, .noise = 0, .holes = false});
  const Cloud& c = scene.cloud;
  const auto point = [&](std::size_t i) { return Vec3{c.x[i], c.y[i], c.z[i]}; };
  const std::size_t a = 300 * 640 + 200, b = 300 * 640 + 440, d = 420 * 640 + 320;
  ASSERT_EQ(scene.label[a] + scene.label[b] + scene.label[d], 3U);
  const Vec3 normal = unit(cross(point(b) - point(a), point(d) - point(a)));
  std::size_t off = 0, table = 0;
  for (std::size_t i = 0; i < c.size(); ++i) {
    if (scene.label[i] != 1) continue;
    ++table;
    off += std::abs(dot(normal, point(i) - point(a))) > 1e-5 ? 1 : 0;
  }
  EXPECT_LT(off, table / 20);  // the table's edge and legs
}

TEST(TabletopTest, HolesTakeOnlyPointsAway) {
  const SyntheticScene whole = make({.noise = 0, .holes = false});
  const SyntheticScene holed = make({.noise = 0, .holes = true});
  std::size_t lost = 0;
  for (std::size_t i = 0; i < whole.label.size(); ++i) {
    if (holed.label[i] == whole.label[i]) continue;
    ASSERT_EQ(holed.label[i], 0U);
    ++lost;
  }
  EXPECT_GT(lost, 1000U);
  EXPECT_LT(lost, whole.label.size() / 10);
}

TEST(TabletopTest, DistanceMovesTheCameraAway) {
  const auto mean_depth = [](double distance) {
    const SyntheticScene scene = make({.noise = 0, .distance = distance});
    double sum = 0;
    std::size_t points = 0;
    for (std::size_t i = 0; i < scene.label.size(); ++i) {
      if (scene.label[i] < 20) continue;
      sum += scene.cloud.z[i];
      ++points;
    }
    return sum / static_cast<double>(points);
  };
  EXPECT_NEAR(mean_depth(2) / mean_depth(1), 2, 0.25);
}

// The more crowded, the more objects border on one another in the picture.
TEST(TabletopTest, ClutterDrawsObjectsTogether) {
  const auto borders = [](double clutter) {
    std::size_t pairs = 0;
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      const SyntheticScene scene = make(
          {.seed = seed, .width = 320, .height = 240, .objects = 12, .stacked = 0, .clutter = clutter, .noise = 0});
      for (std::size_t i = 1; i < scene.label.size(); ++i) {
        const std::uint32_t left = scene.label[i - 1], right = scene.label[i];
        pairs += left >= 20 && right >= 20 && left / 10 != right / 10 ? 1 : 0;
      }
    }
    return pairs;
  };
  EXPECT_GT(borders(1), 2 * borders(0));
}

TEST(SceneOptionsTest, EveryWrongOptionIsNamed) {
  const auto status =
      make_tabletop({.width = 8, .objects = 41, .stacked = -0.1, .noise = std::numeric_limits<double>::quiet_NaN()})
          .status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()),
              AllOf(HasSubstr("width is 8, must be in [16, 4096]"), HasSubstr("objects is 41"),
                    HasSubstr("stacked is -0.1, must be in [0, 1]"), HasSubstr("noise is nan")));
}

}  // namespace
}  // namespace segserve::synth
