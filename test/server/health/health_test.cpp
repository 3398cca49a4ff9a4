// SPDX-License-Identifier: Apache-2.0
#include <future>
#include <memory>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "grpc/health/v1/health.grpc.pb.h"
#include "grpcpp/generic/generic_stub.h"
#include "grpcpp/grpcpp.h"
#include "server/health/health_state.hpp"
#include "test/server/support/fake_backend.hpp"
#include "test/server/support/running_server.hpp"
#include "test/server/support/server_scenes.hpp"

namespace segserve::server {
namespace {

using namespace std::chrono_literals;
using grpc::health::v1::Health;
using grpc::health::v1::HealthCheckRequest;
using grpc::health::v1::HealthCheckResponse;

constexpr const char* kService = "segserve.v1.SegmentationService";

HealthCheckRequest request_for_health(const std::string& service) {
  HealthCheckRequest request;
  request.set_service(service);
  return request;
}

/// "SERVING", or the name of the error.
std::string ask(const std::shared_ptr<grpc::Channel>& channel, const std::string& service) {
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + 5s);
  HealthCheckResponse response;
  const grpc::Status status = Health::NewStub(channel)->Check(&context, request_for_health(service), &response);
  if (status.ok()) return HealthCheckResponse::ServingStatus_Name(response.status());
  return status.error_code() == grpc::StatusCode::NOT_FOUND ? "NOT_FOUND" : status.error_message();
}

struct Watcher {
  Watcher(const std::shared_ptr<grpc::Channel>& channel, const std::string& service)
      : stub(Health::NewStub(channel)), reader(stub->Watch(&context, request_for_health(service))) {}
  ~Watcher() { context.TryCancel(); }

  std::string next() {
    HealthCheckResponse response;
    return reader->Read(&response) ? HealthCheckResponse::ServingStatus_Name(response.status())
                                   : reader->Finish().error_message();
  }

  grpc::ClientContext context;
  std::unique_ptr<Health::Stub> stub;
  std::unique_ptr<grpc::ClientReader<HealthCheckResponse>> reader;
};

class HealthTest : public testing::Test {
 protected:
  static ServerOptions with_probes() {
    ServerOptions options = small_server();
    options.health_listen = "127.0.0.1:0";
    return options;
  }

  std::shared_ptr<grpc::Channel> probe_channel() {
    return grpc::CreateChannel("127.0.0.1:" + std::to_string(server_.server().health_port()),
                               grpc::InsecureChannelCredentials());
  }

  Blockade blockade_;
  RunningServer server_{with_probes(), blocking_factory(blockade_)};
};

TEST_F(HealthTest, KnowsItsNamesAtBothAddresses) {
  for (const auto& channel : {server_.channel(), probe_channel()}) {
    for (const char* service : {"", "liveness", "readiness", kService}) EXPECT_EQ(ask(channel, service), "SERVING");
    EXPECT_EQ(ask(channel, "other"), "NOT_FOUND");
    EXPECT_EQ(Watcher(channel, "other").next(), "SERVICE_UNKNOWN");
  }
}

TEST_F(HealthTest, IsAliveButNotReadyWhileItDrains) {
  const auto probes = probe_channel();
  Watcher ready(server_.channel(), ""), alive(probes, "liveness");
  EXPECT_EQ(ready.next(), "SERVING");
  EXPECT_EQ(alive.next(), "SERVING");
  grpc::ClientContext context;
  auto segmented = server_.segment_later(context, request_for(equal_points(9, 0, 0, 1)));
  ASSERT_TRUE(eventually([&] { return blockade_.entered() == 1; }));
  auto stopped = std::async(std::launch::async, [&] { return server_.server().stop(); });
  EXPECT_EQ(ready.next(), "NOT_SERVING");
  for (const auto& channel : {server_.channel(), probes}) {
    for (const char* service : {"", "readiness", kService}) EXPECT_EQ(ask(channel, service), "NOT_SERVING");
    EXPECT_EQ(ask(channel, "liveness"), "SERVING");
  }
  blockade_.release();
  EXPECT_TRUE(segmented.get().ok());
  EXPECT_TRUE(stopped.get());
  EXPECT_EQ(ready.next(), "the server stops");
  EXPECT_EQ(alive.next(), "the server stops");
}

TEST_F(HealthTest, IsNeitherAliveNorReadyWithoutItsListener) {
  Watcher alive(probe_channel(), "liveness");
  EXPECT_EQ(alive.next(), "SERVING");
  server_.server().set_alive(false);
  EXPECT_EQ(alive.next(), "NOT_SERVING");
  EXPECT_EQ(ask(probe_channel(), "readiness"), "NOT_SERVING");
}

TEST_F(HealthTest, AnswersNothingElseAtTheAddressOfProbes) {
  const auto stub = v1::SegmentationService::NewStub(probe_channel());
  grpc::ClientContext context;
  v1::GetServerInfoResponse info;
  EXPECT_EQ(stub->GetServerInfo(&context, {}, &info).error_code(), grpc::StatusCode::UNIMPLEMENTED);
}

TEST_F(HealthTest, BoundsRequestsAndTheWatchesOfAClient) {
  EXPECT_THAT(ask(server_.channel(), std::string(2000, 'x')), testing::HasSubstr("more than 1024 bytes"));
  std::vector<std::unique_ptr<Watcher>> watchers(100);
  for (auto& watcher : watchers) watcher = std::make_unique<Watcher>(server_.channel(), "");
  for (const auto& watcher : watchers) ASSERT_EQ(watcher->next(), "SERVING");
  EXPECT_THAT(Watcher(server_.channel(), "").next(), testing::HasSubstr("too many calls of this client watch"));
  EXPECT_EQ(ask(server_.channel(), ""), "SERVING");
  watchers.clear();
  EXPECT_TRUE(eventually([&] { return Watcher(server_.channel(), "").next() == "SERVING"; }));
}

struct SilentObserver final : HealthObserver {
  void on_change() override {}
  void on_close() override {}
};

TEST(HealthState, BoundsTheWatchesOfAllClients) {
  HealthState state;
  std::vector<std::shared_ptr<HealthObserver>> observers(1000);
  for (std::size_t i = 0; i < observers.size(); ++i) {
    observers[i] = std::make_shared<SilentObserver>();
    ASSERT_TRUE(state.add(observers[i], "ipv4:192.0.2." + std::to_string(i / 100)).ok());
  }
  const auto another = std::make_shared<SilentObserver>();
  EXPECT_TRUE(absl::IsResourceExhausted(state.add(another, "ipv4:198.51.100.1")));
  state.remove(observers[7]);
  EXPECT_TRUE(absl::IsResourceExhausted(state.add(another, "ipv4:192.0.2.1"))) << "this client has 100";
  EXPECT_TRUE(state.add(another, "ipv4:192.0.2.0").ok());
}

}  // namespace
}  // namespace segserve::server
