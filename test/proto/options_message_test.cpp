// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/options_message.hpp"

#include <cmath>
#include <string>

#include "gmock/gmock.h"

namespace segserve::wire {
namespace {

Options parse(const v1::SegmentOptions& message, const Options& defaults = {}) {
  std::vector<FieldViolation> faults;
  const Options options = from_message(message, defaults, faults);
  EXPECT_THAT(faults, testing::IsEmpty());
  return options;
}

TEST(WireOptions, EveryMethodRoundTrips) {
  for (const Method method : all_methods()) EXPECT_EQ(from_message(to_message(method)), method);
}

TEST(WireOptions, EveryPresetRoundTrips) {
  for (const Preset preset : all_presets()) {
    EXPECT_EQ(from_message(to_message(preset)), preset);
    EXPECT_EQ(parse(to_message(Options{.preset = preset})).preset, preset);
  }
  v1::SegmentOptions automatic;
  automatic.set_preset(v1::PRESET_AUTO);
  EXPECT_EQ(parse(automatic, {.preset = Preset::kRoom}).preset, Preset::kAuto);
  EXPECT_EQ(parse({}, {.preset = Preset::kRoom}).preset, Preset::kRoom);
}

TEST(WireOptions, EveryOptionRoundTrips) {
  Options options;
  options.method = Method::kFixedLambda;
  options.voxel_resolution = 0.01;
  options.seed_resolution = 0.2;
  options.color_weight = 1;
  options.spatial_weight = 2;
  options.normal_weight = 3;
  options.lambda = 0.125;
  options.regions = 7;
  options.min_segment_points = 50;
  options.crop_min_x = -1;
  options.crop_max_x = 1;
  options.crop_min_y = -2;
  options.crop_max_y = 2;
  options.crop_min_z = -3;
  options.crop_max_z = 3;
  options.range_min = 0.5;
  options.range_max = 1.5;
  options.support_plane_distance = 0.01;
  options.threads = 4;
  const Options read = parse(to_message(options));
  EXPECT_EQ(to_message(read).SerializeAsString(), to_message(options).SerializeAsString());
  EXPECT_EQ(read, options);
  EXPECT_EQ(read.normal_weight, 3);
  EXPECT_EQ(read.regions, 7U);
  EXPECT_EQ(read.threshold, std::nullopt);
}

TEST(WireOptions, UnsetFieldsAreTheServersDefaults) {
  Options defaults;
  defaults.voxel_resolution = 0.02;
  defaults.threshold = 0.3;
  const Options options = parse({}, defaults);
  EXPECT_EQ(to_message(options).SerializeAsString(), to_message(defaults).SerializeAsString());
}

TEST(WireOptions, ACutReplacesTheDefaultCut) {
  Options defaults;
  defaults.threshold = 0.3;
  v1::SegmentOptions message;
  message.set_regions(5);
  const Options options = parse(message, defaults);
  EXPECT_EQ(options.threshold, std::nullopt);
  EXPECT_EQ(options.regions, 5U);
}

TEST(WireOptions, NamesEveryWrongOptionByItsPath) {
  v1::SegmentOptions message;
  message.set_method(static_cast<v1::Method>(42));
  message.set_preset(static_cast<v1::Preset>(42));
  message.set_voxel_resolution(NAN);
  message.set_lambda(2);
  message.set_threshold(-1);
  message.set_threads(0);
  std::vector<FieldViolation> faults;
  from_message(message, {}, faults);
  std::vector<std::string> fields;
  for (const FieldViolation& fault : faults) fields.push_back(fault.field);
  EXPECT_THAT(fields, testing::IsSupersetOf({"options.method", "options.preset", "options.voxel_resolution",
                                             "options.lambda", "options.threshold", "options.threads"}));
}

TEST(WireOptions, NamesWhatIsWrongForTheViewByItsPath) {
  const Options options{.range_max = 2};
  EXPECT_THAT(violations_in_view(options, View::camera()), testing::IsEmpty());
  EXPECT_THAT(violations_in_view(options, View::world()),
              testing::ElementsAre(testing::Field(&FieldViolation::field, "options.range_max")));
}

TEST(WireOptions, EveryOptionOfCoreIsAFieldOfTheMessage) {
  for (const OptionInfo& option : option_table()) {
    EXPECT_NE(v1::SegmentOptions::descriptor()->FindFieldByName(std::string(option.name)), nullptr) << option.name;
  }
}

TEST(OptionsHash, DependsOnWhatDecidesResultsOnly) {
  const std::string hash = options_hash({});
  EXPECT_EQ(hash.size(), 16U);
  Options options;
  options.threads = 8;
  options.threshold = default_threshold(options.method);
  EXPECT_EQ(options_hash(options), hash) << "neither threads nor a default that is spelled out";
  options.lambda = 0.7;
  EXPECT_EQ(options_hash(options), hash) << "lambda only counts for fixed-lambda";
  options.normal_weight = 0.5;
  EXPECT_NE(options_hash(options), hash);
  EXPECT_NE(options_hash({.crop_min_x = 1}), hash);
  EXPECT_NE(options_hash({.preset = Preset::kRoom}), hash);
  EXPECT_NE(options_hash({.preset = Preset::kRoom}), options_hash({.preset = Preset::kScan}));
  EXPECT_NE(options_hash({.crop_min_x = 1}), options_hash({.crop_min_y = 1}));

  Options by_threshold, by_regions;
  by_threshold.threshold = 1;
  by_regions.regions = 1;
  EXPECT_NE(options_hash(by_threshold), options_hash(by_regions));
}

TEST(OptionsHash, IsTheSameOnEveryCpu) { EXPECT_EQ(options_hash({}), "83c442c58290d1d5"); }

}  // namespace
}  // namespace segserve::wire
