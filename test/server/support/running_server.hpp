// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <future>
#include <memory>
#include <utility>

#include "grpc/health/v1/health.grpc.pb.h"
#include "grpcpp/grpcpp.h"
#include "gtest/gtest.h"
#include "proto/wire/status_message.hpp"
#include "proto/wire/transport_limits.hpp"
#include "segserve/v1/segmentation_service.grpc.pb.h"
#include "server/server.hpp"

namespace segserve::server {

inline ServerOptions small_server() {
  ServerOptions options;
  options.listen = "127.0.0.1:0";
  options.workers = 1;
  options.drain_delay = std::chrono::milliseconds(0);
  return options;
}

/// A server in this process and a client connected to it through the loopback.
class RunningServer {
 public:
  explicit RunningServer(const ServerOptions& options = small_server(),
                         const BackendFactory& factory = core_backend_factory(), ServiceObservers observers = {})
      : server_(Server::start(options, factory, std::move(observers)).value()) {
    grpc::ChannelArguments arguments;
    arguments.SetMaxReceiveMessageSize(wire::kClientReceiveBytes);
    channel_ = grpc::CreateCustomChannel(server_->address(), grpc::InsecureChannelCredentials(), arguments);
    stub_ = v1::SegmentationService::NewStub(channel_);
  }

  Server& server() { return *server_; }
  const std::shared_ptr<grpc::Channel>& channel() { return channel_; }
  v1::SegmentationService::Stub& stub() { return *stub_; }

  absl::StatusOr<v1::SegmentResponse> segment(const v1::SegmentRequest& request) {
    grpc::ClientContext context;
    v1::SegmentResponse response;
    const grpc::Status status = stub_->Segment(&context, request, &response);
    if (!status.ok()) return wire::from_grpc(status);
    return response;
  }

  /// Makes the call on a connection of its own, as another client would.
  absl::Status segment_from_elsewhere(const v1::SegmentRequest& request) {
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    const auto stub = v1::SegmentationService::NewStub(
        grpc::CreateCustomChannel(server_->address(), grpc::InsecureChannelCredentials(), arguments));
    grpc::ClientContext context;
    v1::SegmentResponse response;
    return wire::from_grpc(stub->Segment(&context, request, &response));
  }

  /// Makes the call in a thread of its own. The context, which can cancel it, must outlive the call.
  std::future<absl::Status> segment_later(grpc::ClientContext& context, v1::SegmentRequest request) {
    return std::async(std::launch::async, [this, &context, request = std::move(request)] {
      v1::SegmentResponse response;
      return wire::from_grpc(stub_->Segment(&context, request, &response));
    });
  }

  grpc::health::v1::HealthCheckResponse::ServingStatus health(const std::string& service = "") {
    grpc::ClientContext context;
    grpc::health::v1::HealthCheckRequest request;
    grpc::health::v1::HealthCheckResponse response;
    request.set_service(service);
    const grpc::Status status = grpc::health::v1::Health::NewStub(channel_)->Check(&context, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response.status();
  }

 private:
  std::unique_ptr<Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<v1::SegmentationService::Stub> stub_;
};

}  // namespace segserve::server
