// SPDX-License-Identifier: Apache-2.0
#include "server/listener/call_counter.hpp"

#include <chrono>
#include <memory>
#include <utility>
#include <vector>

#include "grpcpp/generic/async_generic_service.h"
#include "grpcpp/server_context.h"
#include "grpcpp/support/server_interceptor.h"

namespace segserve::server {
namespace {

CallFlood::Call name_of(const grpc::ServerContextBase* context) { return context; }

/// gRPC asks for a context when a call arrives, and gives it back when the call has ended.
class ContextCounter final : public grpc::ContextAllocator {
 public:
  explicit ContextCounter(CallFlood& flood) : flood_(flood) {}

  grpc::CallbackServerContext* NewCallbackServerContext() override { return make<grpc::CallbackServerContext>(); }
  grpc::GenericCallbackServerContext* NewGenericCallbackServerContext() override {
    return make<grpc::GenericCallbackServerContext>();
  }
  void Release(grpc::CallbackServerContext* context) override { end(context); }
  void Release(grpc::GenericCallbackServerContext* context) override { end(context); }

 private:
  template <typename Context>
  Context* make() {
    auto context = std::make_unique<Context>();
    flood_.on_arrival();
    return context.release();
  }
  template <typename Context>
  void end(Context* context) {
    flood_.on_end(name_of(context));
    delete context;
  }

  CallFlood& flood_;
};

/// gRPC asks for an interceptor when the turn of a call has come.
class TurnCounter final : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  using OnFlood = std::function<void(const std::string&)>;

  TurnCounter(CallFlood& flood, OnFlood on_flood) : flood_(flood), on_flood_(std::move(on_flood)) {}

  grpc::experimental::Interceptor* CreateServerInterceptor(grpc::experimental::ServerRpcInfo* info) override {
    const std::string peer = info->server_context()->peer();
    if (flood_.on_begin(name_of(info->server_context()), peer, std::chrono::steady_clock::now())) on_flood_(peer);
    return nullptr;  // nothing of the call is intercepted
  }

 private:
  CallFlood& flood_;
  const OnFlood on_flood_;
};

}  // namespace

void count_calls(grpc::ServerBuilder& builder, CallFlood& flood,
                 std::function<void(const std::string& peer)> on_flood) {
  builder.SetContextAllocator(std::make_unique<ContextCounter>(flood));
  std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>> creators;
  creators.push_back(std::make_unique<TurnCounter>(flood, std::move(on_flood)));
  builder.experimental().SetInterceptorCreators(std::move(creators));
}

}  // namespace segserve::server
