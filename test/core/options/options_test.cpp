#include "segserve/options/options.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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

TEST(Options, TableHoldsTheDefaultsAndTheyAreInRange) {
  for (const OptionInfo& option : option_table()) {
    EXPECT_LT(option.minimum, option.maximum) << option.name;
    EXPECT_FALSE(option.description.empty()) << option.name;
    if (option.default_value) {
      EXPECT_GE(*option.default_value, option.minimum) << option.name;
      EXPECT_LE(*option.default_value, option.maximum) << option.name;
    }
  }
}

TEST(Options, EveryFaultIsNamedAtOnce) {
  Options options;
  options.voxel_resolution = -1;
  options.seed_resolution = std::numeric_limits<double>::quiet_NaN();
  options.weights.normal = std::numeric_limits<double>::infinity();
  options.threshold = -1;
  options.regions = 0;
  options.threads = 0;
  options.lambda = 2;
  const std::vector<FieldViolation> faults = violations(options);
  EXPECT_THAT(faults, ElementsAre(Field(&FieldViolation::field, "voxel_resolution"),
                                  Field(&FieldViolation::field, "seed_resolution"),
                                  Field(&FieldViolation::field, "normal_weight"),
                                  Field(&FieldViolation::field, "lambda"), Field(&FieldViolation::field, "threshold"),
                                  Field(&FieldViolation::field, "regions"), Field(&FieldViolation::field, "threads"),
                                  Field(&FieldViolation::field, "regions")));
  const absl::Status status = check(options);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("voxel_resolution: -1 is not in [0.001, 1] m"));
  EXPECT_THAT(std::string(status.message()), HasSubstr("threshold: -1 is not in [0, 1]"));
}

TEST(Options, ANotANumberThresholdIsNoThreshold) {
  Options options;
  options.threshold = std::nan("");
  EXPECT_THAT(std::string(check(options).message()), HasSubstr("threshold: nan is not in [0, 1]"));
}

TEST(Options, SeedsAreNotBelowVoxels) {
  Options options;
  options.voxel_resolution = 0.1;
  options.seed_resolution = 0.05;
  EXPECT_THAT(std::string(check(options).message()), HasSubstr("seed_resolution: 0.05 m is below voxel_resolution, 0.1 m"));
}

TEST(Methods, HaveNamesThatLeadBackToThem) {
  EXPECT_EQ(all_methods().size(), 7U);
  for (const Method method : all_methods()) EXPECT_EQ(method_from_name(name(method)), method);
  EXPECT_EQ(method_from_name("nonsense"), std::nullopt);
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
