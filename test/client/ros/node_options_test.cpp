// SPDX-License-Identifier: Apache-2.0
#include "client/ros/core/node_options.hpp"

#include <gmock/gmock.h>

#include <chrono>
#include <fstream>
#include <iterator>
#include <set>
#include <string>

namespace segserve::ros {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(NodeOptions, AreTheDefaultsWithoutParameters) {
  const auto options = parse_parameters({{"method", ""}, {"threshold", ""}});
  ASSERT_TRUE(options.ok()) << options.status();
  EXPECT_EQ(options->segmentation, Options());
  EXPECT_EQ(options->time_to_live, std::chrono::milliseconds(500));
  EXPECT_FALSE(options->view);
  EXPECT_FALSE(options->client.tls);
}

TEST(NodeOptions, TakeTheDefaultsOfTheTable) {
  std::map<std::string, std::string> values;
  for (const ParameterInfo& info : parameter_table()) values[info.name] = info.default_value;
  const auto options = parse_parameters(values);
  ASSERT_TRUE(options.ok()) << options.status();
  const NodeOptions defaults;
  EXPECT_EQ(options->segmentation, defaults.segmentation);
  EXPECT_EQ(options->client.address, defaults.client.address);
  EXPECT_EQ(options->max_in_flight, defaults.max_in_flight);
  EXPECT_EQ(options->min_points, defaults.min_points);
  EXPECT_EQ(options->time_to_live, defaults.time_to_live);
  EXPECT_EQ(options->track, defaults.track);
}

TEST(NodeOptions, ComeFromParameters) {
  const auto options = parse_parameters({{"address", "robot:1,robot:2"},
                                         {"view", "world:1,2,3"},
                                         {"method", "border"},
                                         {"preset", "lidar"},
                                         {"threshold", "0.25"},
                                         {"range_max", "4"},
                                         {"threads", "2"},
                                         {"time_to_live", "0"},
                                         {"max_in_flight", "3"},
                                         {"min_points", "9"},
                                         {"track", "true"},
                                         {"fallback_to_local", "true"},
                                         {"tls_ca", "ca.pem"},
                                         {"tls_cert", "node.pem"},
                                         {"tls_key", "node.key"},
                                         {"token_file", "token"}});
  ASSERT_TRUE(options.ok()) << options.status();
  EXPECT_EQ(options->client.address, "robot:1,robot:2");
  EXPECT_EQ(options->view, View::world(1, 2, 3));
  EXPECT_EQ(options->segmentation.method, Method::kBorder);
  EXPECT_EQ(options->segmentation.preset, Preset::kLidar);
  EXPECT_EQ(options->segmentation.threshold, 0.25);
  EXPECT_EQ(options->segmentation.range_max, 4);
  EXPECT_EQ(options->segmentation.threads, 2U);
  EXPECT_FALSE(options->time_to_live);
  EXPECT_EQ(options->max_in_flight, 3U);
  EXPECT_EQ(options->min_points, 9U);
  EXPECT_TRUE(options->track && options->fallback_to_local);
  ASSERT_TRUE(options->client.tls);
  EXPECT_EQ(options->client.tls->ca_file, "ca.pem");
  EXPECT_EQ(options->client.tls->cert_file, "node.pem");
  EXPECT_EQ(options->client.tls->key_file, "node.key");
  EXPECT_EQ(options->client.token_file, "token");
}

TEST(NodeOptions, EveryWrongParameterIsNamed) {
  const auto options = parse_parameters({{"treshold", "1"},
                                         {"threshold", "high"},
                                         {"voxel_resolution", "-1"},
                                         {"view", "above"},
                                         {"method", "best"},
                                         {"preset", "kitchen"},
                                         {"track", "1"},
                                         {"max_in_flight", "2.5"},
                                         {"time_to_live", "nan"}});
  EXPECT_EQ(options.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(
      std::string(options.status().message()),
      AllOf(HasSubstr("treshold: there is no such parameter"), HasSubstr("threshold: 'high' must be a number"),
            HasSubstr("voxel_resolution: '-1'"), HasSubstr("view: 'above' must be camera"),
            HasSubstr("method: 'best' must be one of border"),
            HasSubstr("preset: 'kitchen' must be one of auto, tabletop"), HasSubstr("track: '1' must be true or false"),
            HasSubstr("max_in_flight: '2.5' must be a whole number from 1 to 1024"), HasSubstr("time_to_live: 'nan'")));
}

TEST(NodeOptions, AreAllInTheReadme) {
  std::ifstream file(SEGSERVE_ROS_README);
  const std::string readme{std::istreambuf_iterator<char>(file), {}};
  std::set<std::string> names;
  for (const ParameterInfo& info : parameter_table()) {
    EXPECT_TRUE(names.insert(info.name).second) << info.name;
    EXPECT_THAT(readme, HasSubstr("| `" + info.name + "` | " + info.unit)) << "the table of client/ros/README.md";
  }
}

}  // namespace
}  // namespace segserve::ros
