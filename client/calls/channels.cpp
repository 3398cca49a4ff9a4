// SPDX-License-Identifier: Apache-2.0
#include "client/calls/channels.hpp"

#include <algorithm>
#include <random>
#include <string_view>
#include <utility>

#include "client/fleet/server_name.hpp"
#include "client/tls/handshake_fault.hpp"
#include "core/base/loopback_host.hpp"
#include "grpcpp/create_channel.h"
#include "grpcpp/security/credentials.h"
#include "grpcpp/support/channel_arguments.h"
#include "proto/wire/transport_limits.hpp"

namespace segserve::client {
namespace {

constexpr int kPingMs = 3'600'000;
constexpr int kUnacknowledgedMs = 10'000;

/// Whether an address, HOST:PORT, [IPv6]:PORT or unix:PATH, leads to this machine.
bool is_loopback(std::string_view address) {
  if (address.starts_with("unix:")) return true;
  std::string_view host = address.substr(0, address.rfind(':'));
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  return is_loopback_host(std::string(host));
}

std::shared_ptr<grpc::ChannelCredentials> credentials_of(const ClientTls& tls) {
  const tls::TlsContents& contents = tls.identity->contents;
  return grpc::SslCredentials({.pem_root_certs = contents.authorities,
                               .pem_private_key = contents.key,
                               .pem_cert_chain = contents.certificate});
}

std::shared_ptr<grpc::Channel> make_channel(const Server& server, bool use_proxy, const std::optional<TlsSource>& tls) {
  grpc::ChannelArguments arguments;
  if (!server.authority.empty()) arguments.SetString(GRPC_ARG_DEFAULT_AUTHORITY, server.authority);
  if (tls && !tls->current().server_name.empty()) arguments.SetSslTargetNameOverride(tls->current().server_name);
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, use_proxy && !is_loopback(server.address) ? 1 : 0);
  arguments.SetMaxReceiveMessageSize(wire::kClientReceiveBytes);
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  arguments.SetInt(GRPC_ARG_HTTP2_STREAM_LOOKAHEAD_BYTES, wire::kFlowControlBytes);
  // Calls are repeated by this library, which must not wait for a backoff of gRPC's.
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
  arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, 2000);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 2000);
  arguments.SetInt(GRPC_ARG_DNS_MIN_TIME_BETWEEN_RESOLUTIONS_MS, 2000);
  // Where the network is cut, gRPC ends a call only when the kernel gives up what was written, by default after a
  // quarter of an hour. These two set TCP_USER_TIMEOUT to the second. The pings are so rare that no server minds them.
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, kPingMs);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, kUnacknowledgedMs);
  arguments.SetServiceConfigJSON(R"({"loadBalancingConfig": [{"round_robin": {}}]})");
  return grpc::CreateCustomChannel(
      server.target, tls ? credentials_of(tls->current()) : grpc::InsecureChannelCredentials(), arguments);
}

}  // namespace

Channels::Channels(const std::vector<std::string>& addresses, bool use_proxy, std::optional<TlsSource> tls,
                   std::shared_ptr<TokenSource> token)
    : use_proxy_(use_proxy),
      token_(std::move(token)),
      fleet_(addresses, !use_proxy),
      turns_(std::random_device()()),
      tls_(std::move(tls)) {}

Channels::Channels(const std::string& address, std::shared_ptr<grpc::Channel> channel)
    : given_(std::move(channel)), use_proxy_(false), fleet_({address}, false), turns_(0) {}

std::shared_ptr<grpc::Channel> Channels::get(const Server& server) {
  if (given_) return given_;
  const std::vector<Server> servers = fleet_.servers().servers;
  const MutexLock lock(mutex_);
  if (tls_ && tls_->refresh(std::chrono::steady_clock::now())) channels_.clear();
  std::shared_ptr<grpc::Channel>& channel = channels_[server.id];
  if (channel) return channel;
  std::shared_ptr<grpc::Channel> made = channel = make_channel(server, use_proxy_, tls_);
  forget_others(servers);
  return made;
}

/// Names may stand for ever other servers.
void Channels::forget_others(const std::vector<Server>& servers) {
  std::erase_if(channels_, [&](const auto& channel) {
    return std::ranges::find(servers, channel.first, &Server::id) == servers.end();
  });
}

absl::Status Channels::handshake_fault(const std::string& address, std::chrono::milliseconds timeout) {
  // The probe would not take the way of the connection.
  if (given_ || (use_proxy_ && !is_loopback(address))) return absl::OkStatus();
  const std::vector<Server> servers = fleet_.servers().servers;
  const auto server = std::ranges::find(servers, address, &Server::address);
  std::optional<ClientTls> tls;
  {
    const MutexLock lock(mutex_);
    if (tls_) tls = tls_->current();
  }
  const auto name = server == servers.end() ? std::nullopt : name_to_look_up(server->authority);
  if (tls && name && tls->server_name.empty()) tls->server_name = name->host;
  return find_handshake_fault(address, tls, timeout);
}

void Channels::renew(const Server& server, const std::shared_ptr<grpc::Channel>& cut) {
  const MutexLock lock(mutex_);
  const auto channel = channels_.find(server.id);
  if (channel != channels_.end() && channel->second == cut) channels_.erase(channel);
}

void Channels::authorize(grpc::ClientContext& call) {
  const std::string token = token_ ? token_->token() : "";
  if (!token.empty()) call.AddMetadata("authorization", "Bearer " + token);
}

}  // namespace segserve::client
