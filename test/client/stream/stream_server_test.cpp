// SPDX-License-Identifier: Apache-2.0
// Streams against real servers in this process.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "fmt/format.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "proto/wire/status_message.hpp"
#include "segserve/client/client.hpp"
#include "segserve/segment.hpp"
#include "server/server.hpp"
#include "test/client/client_scenes.hpp"

namespace segserve::client {
namespace {

using std::chrono::milliseconds;

std::unique_ptr<server::Server> start_server(const server::ServerOptions& changed = {}) {
  server::ServerOptions options = changed;
  options.listen = "127.0.0.1:0";
  return server::Server::start(options).value();
}

Client client_of(std::initializer_list<const server::Server*> servers) {
  std::string addresses;
  for (const server::Server* server : servers) {
    addresses += fmt::format("{}{}", addresses.empty() ? "" : ",", server->address());
  }
  return *Client::connect({.address = addresses});
}

/// Starts a thread that sends the same cloud many times.
std::thread sender_of(Stream& stream, const Cloud& cloud, int count) {
  return std::thread([&stream, &cloud, count] {
    for (int i = 0; i < count; ++i) EXPECT_TRUE(stream.send(cloud).ok());
    stream.finish();
  });
}

TEST(StreamAndServer, EveryFrameGivesWhatTheCoreGives) {
  const auto server = start_server();
  const Cloud cloud = table_scene();
  const auto local = segment(cloud, {});
  ASSERT_TRUE(local.ok());
  for (const Order order : {Order::kSent, Order::kDone}) {
    auto stream = client_of({server.get()}).open_stream({.order = order, .max_in_flight = 4});
    ASSERT_TRUE(stream.ok()) << stream.status();
    std::thread sender = sender_of(*stream, cloud, 12);
    int results = 0;
    while (const auto outcome = stream->next()) {
      ASSERT_EQ(outcome->kind, OutcomeKind::kResult) << outcome->status;
      EXPECT_EQ(outcome->result->segmentation.labels, local->labels);
      EXPECT_EQ(outcome->result->segmentation.tree, local->tree);
      ++results;
      if (order == Order::kSent) {
        EXPECT_EQ(outcome->sequence, static_cast<std::uint64_t>(results));
      }
    }
    sender.join();
    EXPECT_EQ(results, 12);
  }
}

TEST(StreamAndServer, ASharedCloudIsSentFromWhereItIsAndGivenBack) {
  const auto server = start_server();
  for (const wire::Codec codec : {wire::Codec::kPlanar, wire::Codec::kStridedZstd}) {
    auto cloud = std::make_shared<const Cloud>(table_scene());
    const auto local = segment(*cloud, {});
    ASSERT_TRUE(local.ok());
    auto stream = client_of({server.get()}).open_stream({.codec = {.codec = codec}});
    ASSERT_TRUE(stream.ok()) << stream.status();
    for (int round = 0; round < 2; ++round) {
      ASSERT_TRUE(stream->send(cloud).ok());
      const auto outcome = stream->next();
      ASSERT_EQ(outcome->kind, OutcomeKind::kResult) << outcome->status;
      EXPECT_EQ(outcome->result->segmentation.labels, local->labels);
      // gRPC releases what it has sent on another thread, and later.
      for (int i = 0; i < 3000 && cloud.use_count() > 1; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
      EXPECT_EQ(cloud.use_count(), 1) << "the cloud is released after its outcome";
    }
    auto wrong = std::make_shared<Cloud>(*cloud);
    wrong->y.pop_back();
    EXPECT_TRUE(absl::IsInvalidArgument(stream->send(std::shared_ptr<const Cloud>(wrong)).status()));
  }
}

TEST(StreamAndServer, WhenOneOfTwoStopsNoFrameIsLost) {
  server::ServerOptions brief;
  brief.drain_delay = milliseconds(0);
  auto a = start_server(brief);
  auto b = start_server(brief);
  const Cloud cloud = table_scene();
  const auto local = segment(cloud, {});
  auto stream = client_of({a.get(), b.get()}).open_stream({.max_in_flight = 4, .frame_timeout = milliseconds(120'000)});
  ASSERT_TRUE(stream.ok()) << stream.status();
  std::thread sender = sender_of(*stream, cloud, 40);
  std::thread stopper;
  int results = 0;
  std::string stopped, last;
  while (const auto outcome = stream->next()) {
    EXPECT_EQ(outcome->kind, OutcomeKind::kResult) << outcome->status;
    if (outcome->result) {
      EXPECT_EQ(outcome->result->segmentation.labels, local->labels);
    }
    last = outcome->report.address;
    if (++results == 10) {
      stopped = last;
      server::Server& used = outcome->report.address == a->address() ? *a : *b;
      stopper = std::thread([&used] { EXPECT_TRUE(used.stop()); });
    }
  }
  sender.join();
  stopper.join();
  EXPECT_EQ(results, 40);
  EXPECT_NE(last, stopped);
}

TEST(StreamAndServer, WrongOptionsEndTheStreamAndAreNamed) {
  const auto server = start_server();
  const Client client = client_of({server.get()});
  auto stream = client.open_stream();
  Options wrong;
  wrong.threshold = 7;
  ASSERT_TRUE(stream->send(flat_cloud(8, 8), {.options = wrong}).ok());
  const auto outcome = stream->next();
  ASSERT_TRUE(outcome.has_value());
  EXPECT_TRUE(absl::IsInvalidArgument(outcome->status)) << outcome->status;
  EXPECT_EQ(wire::details_of(outcome->status).fields.size(), 1U);
}

TEST(StreamAndServer, ACloudTooLargeForACallIsStreamed) {
  const auto server = start_server();
  const Cloud large = incompressible_cloud(1'000'000);
  Options coarse;
  coarse.voxel_resolution = 0.05;
  coarse.seed_resolution = 0.5;
  const auto local = segment(large, coarse);
  ASSERT_TRUE(local.ok()) << local.status();
  const auto remote = client_of({server.get()}).segment(large, coarse, {.timeout = milliseconds(120'000)});
  ASSERT_TRUE(remote.ok()) << remote.status();
  EXPECT_EQ(remote->segmentation.labels, local->labels);
}

TEST(StreamAndServer, ACancelledFrameEndsAndTheNextOnePasses) {
  const auto server = start_server();
  auto stream = client_of({server.get()}).open_stream({.order = Order::kDone, .max_in_flight = 4});
  const Cloud cloud = table_scene();
  std::vector<std::uint64_t> sequences;
  for (int i = 0; i < 3; ++i) sequences.push_back(*stream->send(cloud));
  stream->cancel(sequences[1]);
  sequences.push_back(*stream->send(cloud));
  stream->finish();
  std::vector<std::uint64_t> ended;
  while (const auto outcome = stream->next()) {
    ended.push_back(outcome->sequence);
    const bool may_be_cancelled = outcome->sequence == sequences[1];
    EXPECT_TRUE(outcome->kind == OutcomeKind::kResult || may_be_cancelled) << outcome->status;
  }
  std::ranges::sort(ended);
  EXPECT_EQ(ended, sequences);
}

}  // namespace
}  // namespace segserve::client
