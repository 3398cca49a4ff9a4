// SPDX-License-Identifier: Apache-2.0
// Clouds that are far too large for one message, to a server with its default limits and back.
#include <chrono>
#include <cmath>

#include "gmock/gmock.h"
#include "segserve/client/client.hpp"
#include "segserve/segment.hpp"
#include "server/server.hpp"

namespace segserve::client {
namespace {

constexpr std::uint32_t kPoints = 10'000'000;

/// Ten meters of colored stairs, in the order in which a scanner would measure them.
Cloud stairs(std::uint32_t points) {
  constexpr std::uint32_t kRow = 2500;
  Cloud cloud;
  cloud.resize(points, true);
  cloud.width = points;
  cloud.height = 1;
  cloud.view.kind = ViewKind::kWorld;
  const auto step = 10.0F / static_cast<float>(points / kRow + 1);
  for (std::uint32_t i = 0; i < points; ++i) {
    const auto tread = static_cast<float>(4 * std::uint64_t{i} / points);
    cloud.x[i] = step * static_cast<float>(i / kRow);
    cloud.y[i] = 0.004F * static_cast<float>(i % kRow);
    cloud.z[i] = 0.5F * tread;
    cloud.rgb[i] = pack_rgb(static_cast<std::uint8_t>(60 * tread), 90, 120);
  }
  return cloud;
}

TEST(LargeCloud, TenMillionPointsPassBothWays) {
  server::ServerOptions server_options;
  server_options.listen = "127.0.0.1:0";
  const auto server = server::Server::start(server_options).value();
  const auto client = Client::connect({.address = server->address(), .timeout = std::chrono::minutes(4)}).value();
  const Cloud cloud = stairs(kPoints);
  Options options;
  options.method = Method::kLambdaConvex;
  options.voxel_resolution = 0.04;
  options.seed_resolution = 0.4;

  const auto remote = client.segment(cloud, options);
  ASSERT_TRUE(remote.ok()) << remote.status();
  const auto local = segment(cloud, options);
  ASSERT_TRUE(local.ok()) << local.status();
  EXPECT_GE(local->segments, 4U);
  EXPECT_EQ(remote->segmentation.labels.size(), kPoints);
  EXPECT_TRUE(remote->segmentation.labels == local->labels);  // EXPECT_EQ would print them
  EXPECT_TRUE(remote->segmentation.supervoxels == local->supervoxels);
  EXPECT_TRUE(remote->segmentation.tree == local->tree);
}

}  // namespace
}  // namespace segserve::client
