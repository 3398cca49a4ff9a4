// SPDX-License-Identifier: Apache-2.0
#include "segserve/options.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace segserve {
namespace {

using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;

TEST(Options, DefaultsAreValid) {
  for (const Method method : all_methods()) {
    Options options;
    options.method = method;
    EXPECT_TRUE(check(options).ok()) << name(method);
  }
}

TEST(Options, TableHoldsDefaultsInRangeForEveryMethod) {
  for (const OptionInfo& option : option_table()) {
    EXPECT_LT(option.minimum, option.maximum) << option.name;
    EXPECT_FALSE(option.description.empty()) << option.name;
    for (const Method method : all_methods()) {
      const std::optional<double> value = default_value(option, method);
      if (value) {
        EXPECT_EQ(violation(option, *value), std::nullopt) << option.name;
      }
    }
  }
}

TEST(Options, AreOnByDefaultUnlessTheyLeavePointsOutOrTheCloudDecides) {
  std::vector<std::string_view> off;
  for (const OptionInfo& option : option_table()) {
    if (!default_value(option, Method::kBorder)) off.push_back(option.name);
  }
  EXPECT_THAT(
      off, ElementsAre("voxel_resolution", "seed_resolution", "regions", "crop_min_x", "crop_max_x", "crop_min_y",
                       "crop_max_y", "crop_min_z", "crop_max_z", "range_min", "range_max", "support_plane_distance"));
}

TEST(Options, TableWritesWhatItReads) {
  for (const OptionInfo& option : option_table()) {
    Options options;
    option.set(options, option.maximum);
    EXPECT_EQ(option.get(options), option.maximum) << option.name;
  }
}

TEST(Options, AreResolvedByTheMethodWhereUnset) {
  const Options paper = resolved({.method = Method::kLambdaConvex, .seed_resolution = 0.05});
  EXPECT_EQ(paper.voxel_resolution, 0.008);
  EXPECT_EQ(paper.seed_resolution, 0.05);
  EXPECT_EQ(paper.threshold, 0.15);
  const Options border = resolved({});
  EXPECT_EQ(border.voxel_resolution, std::nullopt) << "the cloud decides";
  EXPECT_EQ(border.seed_resolution, std::nullopt);
  EXPECT_EQ(border.color_weight, 0);
  EXPECT_EQ(border.threshold, 0.5);
  EXPECT_EQ(resolved({.regions = 3}).threshold, std::nullopt);
  EXPECT_EQ(resolved(border), border);
}

TEST(Options, MustBeWholeWhereTheTableSaysSo) {
  const auto* threads = std::ranges::find(option_table(), "threads", &OptionInfo::name).base();
  EXPECT_EQ(violation(*threads, 2), std::nullopt);
  EXPECT_THAT(violation(*threads, 2.5)->description, HasSubstr("2.5 is not a whole number in [1, 64]"));
}

TEST(Options, AllFaultsAreReportedTogether) {
  Options options;
  options.voxel_resolution = -1;
  options.seed_resolution = std::numeric_limits<double>::quiet_NaN();
  options.normal_weight = std::numeric_limits<double>::infinity();
  options.threshold = -1;
  options.regions = 0;
  options.threads = 0;
  options.lambda = 2;
  const std::vector<FieldViolation> faults = violations(options);
  EXPECT_THAT(
      faults,
      ElementsAre(Field(&FieldViolation::field, "voxel_resolution"), Field(&FieldViolation::field, "seed_resolution"),
                  Field(&FieldViolation::field, "normal_weight"), Field(&FieldViolation::field, "lambda"),
                  Field(&FieldViolation::field, "threshold"), Field(&FieldViolation::field, "regions"),
                  Field(&FieldViolation::field, "threads"), Field(&FieldViolation::field, "regions")));
  const absl::Status status = check(options);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("voxel_resolution: -1 is not in [0.001, 1] m"));
  EXPECT_THAT(std::string(status.message()), HasSubstr("threshold: -1 is not in [0, 1]"));
}

TEST(Options, AThresholdIsANumber) {
  Options options;
  options.threshold = std::nan("");
  EXPECT_THAT(std::string(check(options).message()), HasSubstr("threshold: nan is not in [0, 1]"));
}

TEST(Options, SeedsAreNotBelowVoxels) {
  Options options;
  options.voxel_resolution = 0.1;
  options.seed_resolution = 0.05;
  EXPECT_THAT(std::string(check(options).message()),
              HasSubstr("seed_resolution: 0.05 m is below voxel_resolution, 0.1 m"));
}

TEST(Options, AMaximumIsAboveItsMinimum) {
  const Options options{.crop_min_x = 1,
                        .crop_max_x = 1,
                        .crop_min_y = 0,
                        .crop_max_y = -1,
                        .crop_min_z = 1,
                        .crop_max_z = 2,
                        .range_min = 3,
                        .range_max = 2};
  EXPECT_THAT(violations(options), ElementsAre(FieldViolation{"crop_max_x", "1 m is not above crop_min_x, 1 m"},
                                               FieldViolation{"crop_max_y", "-1 m is not above crop_min_y, 0 m"},
                                               FieldViolation{"range_max", "2 m is not above range_min, 3 m"}));
}

TEST(Options, ThatLeavePointsOutAreNumbersInRange) {
  const Options options{.crop_min_x = std::nan(""), .crop_max_z = 1e9, .range_min = -1, .support_plane_distance = 0};
  EXPECT_THAT(
      violations(options),
      ElementsAre(Field(&FieldViolation::field, "crop_min_x"), Field(&FieldViolation::field, "crop_max_z"),
                  Field(&FieldViolation::field, "range_min"), Field(&FieldViolation::field, "support_plane_distance")));
}

TEST(Options, ThatLimitTheRangeNeedAKnownSensor) {
  const Options options{.range_min = 1, .range_max = 2};
  EXPECT_TRUE(check(options, View::camera()).ok());
  EXPECT_TRUE(check(options, View::world(0, 0, 1)).ok());
  EXPECT_THAT(std::string(check(options, View::world()).message()),
              testing::AllOf(HasSubstr("range_min: the cloud has a WORLD view"), HasSubstr("range_max: the cloud")));
  EXPECT_TRUE(check({.crop_min_x = 1, .support_plane_distance = 0.01}, View::world()).ok());
}

TEST(Methods, HaveNamesThatLeadBackToThem) {
  EXPECT_EQ(all_methods().size(), 8U);
  for (const Method method : all_methods()) EXPECT_EQ(method_from_name(name(method)), method);
  EXPECT_EQ(method_from_name("nonsense"), std::nullopt);
}

TEST(Presets, HaveNamesThatLeadBackToThem) {
  EXPECT_EQ(preset_names(), "auto, tabletop, room, lidar, scan");
  for (const Preset preset : all_presets()) EXPECT_EQ(preset_from_name(name(preset)), preset);
  EXPECT_EQ(preset_from_name("Room"), std::nullopt);
}

TEST(Presets, SayInWhichViewACloudIsSegmented) {
  for (const View& view : {View::camera(), View::world(), View::world(1, 2, 3)}) {
    for (const Preset preset : {Preset::kAuto, Preset::kRoom, Preset::kScan}) {
      EXPECT_EQ(segmented_view(view, preset), view);
    }
    EXPECT_EQ(segmented_view(view, Preset::kTabletop), View::camera());
  }
  EXPECT_EQ(segmented_view(View::world(), Preset::kLidar), View::world(0, 0, 0));
  EXPECT_EQ(segmented_view(View::world(1, 2, 3), Preset::kLidar), View::world(1, 2, 3));
}

TEST(Presets, AreRefusedWhereTheyContradictOtherOptionsOrTheView) {
  const auto fault = [](const Options& options, const View& view = View::world()) {
    return std::string(check(options, view).message());
  };
  EXPECT_EQ(fault({.method = Method::kColor, .preset = Preset::kRoom}),
            "preset: 'room' is for the method border, not for color");
  EXPECT_THAT(fault({.preset = Preset::kLidar, .voxel_resolution = 0.1}), HasSubstr("preset: 'lidar' makes voxels"));
  EXPECT_THAT(fault({.preset = static_cast<Preset>(9)}), HasSubstr("preset: 9 is no preset"));
  EXPECT_THAT(fault({.preset = Preset::kTabletop}, View::world(0, 0, 1)), HasSubstr("not at the origin"));
  EXPECT_EQ(fault({.preset = Preset::kTabletop}, View::world(0, 0, 0)), "");
  EXPECT_THAT(fault({.preset = Preset::kLidar}, View::camera()), HasSubstr("WORLD view of one sensor"));
  EXPECT_THAT(fault({.preset = Preset::kLidar}, View::of_cameras({{.points = 1}})), HasSubstr("WORLD view of one"));
  EXPECT_EQ(fault({.preset = Preset::kLidar, .range_max = 50}), "") << "the sensor is at the origin";
}

TEST(Methods, HaveThePapersThresholds) {
  EXPECT_EQ(default_threshold(*method_from_name("color")), 0.10);
  EXPECT_EQ(default_threshold(*method_from_name("geometry")), 0.29);
  EXPECT_EQ(default_threshold(*method_from_name("lambda")), 0.18);
  EXPECT_EQ(default_threshold(*method_from_name("lambda-convex")), 0.15);
  EXPECT_EQ(default_threshold(*method_from_name("equalization")), 0.94);
  EXPECT_EQ(default_threshold(*method_from_name("equalization-convex")), 0.94);
}

}  // namespace
}  // namespace segserve
