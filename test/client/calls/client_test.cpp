// SPDX-License-Identifier: Apache-2.0
// The client library against a real server in this process.
#include "segserve/client/client.hpp"

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "proto/wire/cloud_message.hpp"
#include "proto/wire/codec_message.hpp"
#include "proto/wire/status_message.hpp"
#include "segserve/codec/pcd.hpp"
#include "segserve/segment.hpp"
#include "segserve/v1/segmentation_service.pb.h"
#include "server/server.hpp"
#include "test/client/client_scenes.hpp"

namespace segserve::client {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;

/// No server listens there.
constexpr const char* kNobody = "127.0.0.1:1";

class ClientTest : public testing::Test {
 protected:
  void SetUp() override { start(server::core_backend_factory()); }

  void start(const server::BackendFactory& segmenter) {
    server::ServerOptions options;
    options.listen = "127.0.0.1:0";
    auto server = server::Server::start(options, segmenter);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }

  Client client() const { return *Client::connect({.address = server_->address()}); }

  std::unique_ptr<server::Server> server_;
};

void expect_equal(const Result& remote, const Segmentation& local) {
  EXPECT_EQ(remote.segmentation.labels, local.labels);
  EXPECT_EQ(remote.segmentation.supervoxels, local.supervoxels);
  EXPECT_EQ(remote.segmentation.tree, local.tree);
  EXPECT_EQ(remote.segmentation.segments, local.segments);
  EXPECT_EQ(remote.segmentation.finite_points, local.finite_points);
}

TEST_F(ClientTest, SegmentsAsTheCoreDoes) {
  const Cloud cloud = table_scene();
  const auto local = segment(cloud, {});
  ASSERT_TRUE(local.ok()) << local.status();
  ASSERT_GT(local->segments, 1U);
  for (const Compress compress : {Compress::kWhenTooLarge, Compress::kAlways, Compress::kNever}) {
    const auto remote = client().segment(cloud, {}, {.compress = compress});
    ASSERT_TRUE(remote.ok()) << remote.status();
    expect_equal(*remote, *local);
    EXPECT_EQ(remote->view, View::camera());
    EXPECT_EQ(remote->method, Options{}.method);
  }
}

TEST_F(ClientTest, EachCodecGivesTheLabelsOfALocalRunOnTheDecodedPayload) {
  const Cloud cloud = table_scene();
  for (const wire::CodecInfo& codec : wire::codecs()) {
    if (codec.kind == v1::PAYLOAD_KIND_DRACO) continue;  // not enabled in this server
    SCOPED_TRACE(codec.name);
    const wire::CodecOptions options{.codec = codec.codec, .error_bound = 0.0005};
    const v1::Cloud message = wire::to_message(cloud, options).value();
    const auto decoded = wire::decode_cloud(message, {});
    ASSERT_TRUE(decoded.ok()) << decoded.status();
    const auto local = segment(decoded->cloud, {});
    ASSERT_TRUE(local.ok()) << local.status();
    const auto remote = client().segment(cloud, {}, {.codec = options});
    ASSERT_TRUE(remote.ok()) << remote.status();
    expect_equal(*remote, *local);
    EXPECT_EQ(remote->points, cloud.size());
  }
}

TEST_F(ClientTest, SegmentsWithTheOptionsGiven) {
  const Cloud cloud = table_scene();
  Options options;
  options.method = Method::kEqualization;
  options.regions = 5;
  options.seed_resolution = 0.12;
  const auto local = segment(cloud, options);
  const auto remote = client().segment(cloud, options);
  ASSERT_TRUE(local.ok() && remote.ok()) << remote.status();
  expect_equal(*remote, *local);
  EXPECT_EQ(remote->segmentation.segments, 5U);
  EXPECT_EQ(remote->method, Method::kEqualization);
  EXPECT_EQ(remote->regions, 5U);
  EXPECT_FALSE(remote->segmentation.threshold.has_value());
}

TEST_F(ClientTest, SegmentsPcdFilesOfEveryEncoding) {
  const Cloud cloud = table_scene();
  const auto local = segment(cloud, {});
  ASSERT_TRUE(local.ok()) << local.status();
  for (const auto encoding :
       {codec::PcdEncoding::kAscii, codec::PcdEncoding::kBinary, codec::PcdEncoding::kBinaryCompressed}) {
    const auto remote = client().segment_pcd_file(codec::encode_pcd(cloud, {}, encoding));
    ASSERT_TRUE(remote.ok()) << remote.status();
    expect_equal(*remote, *local);
  }
}

TEST_F(ClientTest, AViewOverridesThePcdFiles) {
  Cloud cloud = table_scene();
  const std::string file = codec::encode_pcd(cloud, {}, codec::PcdEncoding::kBinary);
  cloud.view = View::world(0, 0, -1);
  const auto local = segment(cloud, {});
  const auto remote = client().segment_pcd_file(file, View::world(0, 0, -1));
  ASSERT_TRUE(local.ok() && remote.ok()) << remote.status();
  expect_equal(*remote, *local);
  EXPECT_EQ(remote->view, View::world(0, 0, -1));
}

TEST_F(ClientTest, ReturnsOnlyTheArraysAskedFor) {
  const auto remote = client().segment(table_scene(), {}, {.outputs = {.labels = true}});
  ASSERT_TRUE(remote.ok()) << remote.status();
  EXPECT_EQ(remote->segmentation.labels.size(), 160U * 120U);
  EXPECT_TRUE(remote->segmentation.supervoxels.empty());
  EXPECT_EQ(remote->segmentation.tree.leaf_count(), 0U);
}

TEST_F(ClientTest, DescribesSegmentsIfAskedToOverAnyWay) {
  const Cloud cloud = table_scene();
  Segmentation local = segment(cloud, {}).value();
  ASSERT_TRUE(describe(cloud, 1, {}, local).ok());
  const CallOptions call{.outputs = {.segments = true}};
  const auto remote = client().segment(cloud, {}, call);
  ASSERT_TRUE(remote.ok()) << remote.status();
  EXPECT_EQ(remote->segmentation.statistics, local.statistics);
  EXPECT_TRUE(client().segment(cloud)->segmentation.statistics.empty());

  auto stream = client().open_stream({.outputs = call.outputs}).value();
  ASSERT_TRUE(stream.send(cloud).ok());
  const auto outcome = stream.next();
  ASSERT_TRUE(outcome && outcome->result);
  EXPECT_EQ(outcome->result->segmentation.statistics, local.statistics);

  const auto alone = Client::connect({.address = "127.0.0.1:1", .fallback_to_local = true});
  const auto here = alone->segment(cloud, {}, call);
  ASSERT_TRUE(here.ok()) << here.status();
  EXPECT_EQ(here->segmentation.statistics, local.statistics);
}

TEST_F(ClientTest, NamesEveryWrongOption) {
  Options options;
  options.voxel_resolution = -1;
  options.threshold = 7;
  const auto remote = client().segment(table_scene(), options);
  EXPECT_TRUE(absl::IsInvalidArgument(remote.status())) << remote.status();
  const std::string message(remote.status().message());
  EXPECT_THAT(message, HasSubstr("voxel_resolution"));
  EXPECT_THAT(message, HasSubstr("threshold"));
  EXPECT_EQ(wire::details_of(remote.status()).fields.size(), 2U);
}

TEST_F(ClientTest, SaysWhatIsWrongWithTheCloud) {
  Cloud cloud = flat_cloud(8, 8);
  for (std::size_t i = 0; i < cloud.size(); i += 3) cloud.z[i] = -1;
  const auto remote = client().segment(cloud);
  EXPECT_TRUE(absl::IsInvalidArgument(remote.status())) << remote.status();
  EXPECT_EQ(wire::details_of(remote.status()).reason, wire::ErrorReason::kInvalidCloud);
}

TEST_F(ClientTest, ServesSeveralThreadsAtOnce) {
  const Cloud cloud = table_scene();
  const auto local = segment(cloud, {});
  ASSERT_TRUE(local.ok()) << local.status();
  const Client shared = client();
  std::vector<std::thread> threads;
  std::vector<absl::StatusOr<Result>> results(4, absl::UnknownError("did not run"));
  for (auto& result : results) {
    threads.emplace_back([&] { result = shared.segment(cloud); });
  }
  for (std::thread& thread : threads) thread.join();
  for (const auto& result : results) {
    ASSERT_TRUE(result.ok()) << result.status();
    expect_equal(*result, *local);
  }
}

/// Computes until it is told to stop.
class EndlessSegmenter final : public server::SegmentationBackend {
 public:
  absl::StatusOr<Segmentation> segment(const CloudView&, const Options&, const StopToken& stop,
                                       const Admission&) override {
    while (stop.check().ok()) std::this_thread::sleep_for(milliseconds(1));
    return stop.check();
  }
};

TEST_F(ClientTest, GivesUpAtTheDeadline) {
  start([] { return std::make_unique<EndlessSegmenter>(); });
  const Client hasty = *Client::connect({.address = server_->address(), .timeout = milliseconds(100)});
  EXPECT_TRUE(absl::IsDeadlineExceeded(hasty.segment(flat_cloud(4, 4)).status()));
  const auto per_call = client().segment(flat_cloud(4, 4), {}, {.timeout = milliseconds(100)});
  EXPECT_TRUE(absl::IsDeadlineExceeded(per_call.status())) << per_call.status();
}

TEST_F(ClientTest, TellsWhatTheServerCanDo) {
  const auto info = client().server_info();
  ASSERT_TRUE(info.ok()) << info.status();
  EXPECT_FALSE(info->version().empty());
  EXPECT_EQ(info->limits().max_points(), server::ServerOptions{}.max_points);
  EXPECT_EQ(static_cast<std::size_t>(info->methods_size()), all_methods().size());
}

TEST_F(ClientTest, HealthIsOkOnlyWhileTheServerServes) {
  EXPECT_EQ(client().health(), absl::OkStatus());
  const Client before = client();
  server_->stop();
  EXPECT_TRUE(absl::IsUnavailable(before.health(milliseconds(2000))));
}

TEST(ClientWithoutServer, FailsAtOnceAndSaysWhoDidNotAnswer) {
  const auto client = Client::connect({.address = kNobody});
  ASSERT_TRUE(client.ok()) << client.status();
  const auto result = client->segment(flat_cloud(4, 4));
  EXPECT_TRUE(absl::IsUnavailable(result.status())) << result.status();
  EXPECT_THAT(std::string(result.status().message()), HasSubstr(kNobody));
  EXPECT_TRUE(absl::IsUnavailable(client->health()));
  EXPECT_TRUE(absl::IsUnavailable(client->server_info().status()));
}

TEST(ClientWithoutServer, WaitsUntilItsDeadlineIfToldTo) {
  const auto client = Client::connect({.address = kNobody, .timeout = milliseconds(300), .wait_for_server = true});
  ASSERT_TRUE(client.ok()) << client.status();
  const auto start = std::chrono::steady_clock::now();
  EXPECT_TRUE(absl::IsDeadlineExceeded(client->health()));
  EXPECT_GE(std::chrono::steady_clock::now() - start, milliseconds(290));
}

TEST(ClientWithoutServer, RefusesOptionsThatMakeNoSense) {
  EXPECT_TRUE(absl::IsInvalidArgument(Client::connect({.address = ""}).status()));
  EXPECT_TRUE(absl::IsInvalidArgument(Client::connect({.timeout = milliseconds(0)}).status()));
}

TEST_F(ClientTest, SendsNoTraceparentThatIsNotValid) {
  const Cloud cloud = table_scene();
  const absl::Status called = client().segment(cloud, {}, {.traceparent = "00-1-2-\n"}).status();
  EXPECT_EQ(called.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(called.message()), HasSubstr("traceparent"));
  Stream stream = client().open_stream().value();
  EXPECT_EQ(stream.send(cloud, {.traceparent = "00-1-2-\n"}).status(), called);
}

}  // namespace
}  // namespace segserve::client
