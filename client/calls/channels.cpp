// SPDX-License-Identifier: Apache-2.0
#include "client/calls/channels.hpp"

#include <string_view>
#include <utility>

#include "grpcpp/create_channel.h"
#include "grpcpp/security/credentials.h"
#include "grpcpp/support/channel_arguments.h"
#include "proto/wire/transport_limits.hpp"

namespace segserve::client {
namespace {

bool is_loopback(std::string_view address) {
  return address.starts_with("127.") || address.starts_with("localhost:") || address.starts_with("[::1]") ||
         address.starts_with("unix:");
}

std::shared_ptr<grpc::Channel> make_channel(const std::string& address, bool use_proxy) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, use_proxy && !is_loopback(address) ? 1 : 0);
  arguments.SetMaxReceiveMessageSize(wire::kClientReceiveBytes);
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  arguments.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, 0);
  arguments.SetInt(GRPC_ARG_HTTP2_STREAM_LOOKAHEAD_BYTES, wire::kFlowControlBytes);
  // Calls are repeated by this library, which must not wait for a backoff of gRPC's.
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
  arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, 2000);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 2000);
  arguments.SetServiceConfigJSON(R"({"loadBalancingConfig": [{"round_robin": {}}]})");
  return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
}

}  // namespace

Channels::Channels(std::vector<std::string> addresses, bool use_proxy)
    : addresses_(std::move(addresses)), made_here_(true), use_proxy_(use_proxy), channels_(addresses_.size()) {}

Channels::Channels(std::string address, std::shared_ptr<grpc::Channel> channel)
    : addresses_{std::move(address)}, made_here_(false), use_proxy_(false), channels_{std::move(channel)} {}

std::shared_ptr<grpc::Channel> Channels::get(std::size_t address) {
  const MutexLock lock(mutex_);
  if (!channels_[address]) channels_[address] = make_channel(addresses_[address], use_proxy_);
  return channels_[address];
}

void Channels::renew(std::size_t address, const std::shared_ptr<grpc::Channel>& cut) {
  const MutexLock lock(mutex_);
  if (made_here_ && channels_[address] == cut) channels_[address] = nullptr;
}

std::size_t Channels::next_start() {
  const MutexLock lock(mutex_);
  return starts_++;
}

}  // namespace segserve::client
