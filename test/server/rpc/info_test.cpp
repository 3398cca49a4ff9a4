// SPDX-License-Identifier: Apache-2.0
#include <map>
#include <string>

#include "gmock/gmock.h"
#include "proto/wire/options_message.hpp"
#include "segserve/options.hpp"
#include "test/server/support/running_server.hpp"

namespace segserve::server {
namespace {

v1::GetServerInfoResponse info_of(RunningServer& server) {
  grpc::ClientContext context;
  v1::GetServerInfoResponse info;
  const grpc::Status status = server.stub().GetServerInfo(&context, {}, &info);
  EXPECT_TRUE(status.ok()) << status.error_message();
  return info;
}

TEST(ServerInfo, TellsTheLimitsOfThisServer) {
  ServerOptions options = small_server();
  options.workers = 3;
  options.threads = 2;
  options.queue = 7;
  options.queue_bytes = 99'000'000;
  options.queue_points = 5555;
  options.max_points = 1234;
  options.max_decoded_bytes = 56'789;
  RunningServer server(options);
  const v1::GetServerInfoResponse info = info_of(server);
  EXPECT_FALSE(info.version().empty());
  EXPECT_EQ(info.limits().workers(), 3U);
  EXPECT_EQ(info.limits().max_threads(), 2U);
  EXPECT_EQ(info.limits().max_queue(), 7U);
  EXPECT_EQ(info.limits().max_queue_bytes(), 99'000'000U);
  EXPECT_EQ(info.limits().max_queue_points(), 5555U);
  EXPECT_EQ(info.limits().max_points(), 1234U);
  EXPECT_EQ(info.limits().max_decoded_bytes(), 56'789U);
  EXPECT_EQ(info.limits().max_message_bytes(), wire::kMaxRequestBytes);
  EXPECT_THAT(info.payload_kinds(),
              testing::ElementsAre(v1::PAYLOAD_KIND_PLANAR, v1::PAYLOAD_KIND_PCD_FILE, v1::PAYLOAD_KIND_STRIDED,
                                   v1::PAYLOAD_KIND_QUANTISED, v1::PAYLOAD_KIND_RGBD));
  EXPECT_THAT(info.compressions(), testing::ElementsAre(v1::COMPRESSION_NONE, v1::COMPRESSION_ZSTD));
}

TEST(ServerInfo, TellsEveryMethodAndOptionOfCore) {
  ServerOptions options = small_server();
  options.defaults.voxel_resolution = 0.016;
  RunningServer server(options);
  const v1::GetServerInfoResponse info = info_of(server);
  ASSERT_EQ(static_cast<std::size_t>(info.methods_size()), all_methods().size());
  for (const v1::MethodInfo& method : info.methods()) {
    const auto ours = method_from_name(method.name());
    ASSERT_TRUE(ours.has_value()) << method.name();
    EXPECT_EQ(wire::from_message(method.method()), ours);
    EXPECT_EQ(method.defaults().threshold(), default_threshold(*ours));
    const std::optional<double> seed = resolved({.method = *ours}).seed_resolution;
    EXPECT_EQ(method.defaults().has_seed_resolution(), seed.has_value()) << "unset where the cloud decides";
    EXPECT_EQ(method.defaults().seed_resolution(), seed.value_or(0));
    EXPECT_EQ(method.defaults().voxel_resolution(), 0.016) << "the server's own default goes before the method's";
  }
  ASSERT_EQ(static_cast<std::size_t>(info.options_size()), option_table().size());
  EXPECT_EQ(info.default_options().voxel_resolution(), 0.016);
}

TEST(ServerInfo, DefaultsAreThoseOfThisServer) {
  ServerOptions options = small_server();
  options.defaults.voxel_resolution = 0.016;
  options.defaults.threshold = 0.5;
  RunningServer server(options);
  std::map<std::string, double> defaults;
  const v1::GetServerInfoResponse info = info_of(server);
  for (const v1::OptionInfo& option : info.options()) {
    if (option.has_default_value()) defaults[option.name()] = option.default_value();
  }
  EXPECT_EQ(defaults.at("voxel_resolution"), 0.016);
  EXPECT_EQ(defaults.at("threshold"), 0.5);
  EXPECT_EQ(defaults.at("threads"), 1);
  EXPECT_FALSE(defaults.contains("regions"));
}

}  // namespace
}  // namespace segserve::server
