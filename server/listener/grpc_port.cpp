// SPDX-License-Identifier: Apache-2.0
#include "server/listener/grpc_port.hpp"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <thread>

#include "core/base/status_macros.hpp"
#include "server/listener/call_counter.hpp"
#include "server/scheduling/client_address.hpp"
#include "spdlog/spdlog.h"

namespace segserve::server {
namespace {

// A line of the log comes after so long without reason for one.
constexpr std::chrono::seconds kSilence{10};

/// A machine with many cores begins more calls before it is flooded.
CallFlood::Limits limits_here() {
  CallFlood::Limits limits;
  const auto cores = static_cast<std::int64_t>(std::thread::hardware_concurrency());
  limits.rate = std::max(limits.rate, 1000 * cores);
  return limits;
}

}  // namespace

GrpcPort::GrpcPort(std::vector<Socket> listeners)
    : port_(port_of(listeners.front())), listeners_(std::move(listeners)), flood_(limits_here()) {}

absl::StatusOr<std::unique_ptr<GrpcPort>> GrpcPort::open(const ListenAddress& address, grpc::ServerBuilder& builder,
                                                         std::shared_ptr<grpc::ServerCredentials> credentials) {
  using Way = grpc::ServerBuilder::experimental_type::ExternalConnectionType;
  ASSIGN_OR_RETURN(std::vector<Socket> listeners, listen_at_all(address));
  std::unique_ptr<GrpcPort> port(new GrpcPort(std::move(listeners)));
  port->entry_ = builder.experimental().AddExternalConnectionAcceptor(Way::FROM_FD, std::move(credentials));
  count_calls(builder, port->flood_, [self = port.get()](const std::string& peer) { self->end(peer); });
  return port;
}

absl::Status GrpcPort::start(std::size_t most) {
  ASSIGN_OR_RETURN(
      acceptor_,
      BoundedAcceptor::start(
          std::move(listeners_), most, [this](Socket connection) { give_to_grpc(std::move(connection)); },
          [this](const std::string& address) { return flood_.is_held(address, std::chrono::steady_clock::now()); }));
  ending_ = acceptor_.get();
  return absl::OkStatus();
}

void GrpcPort::end(const std::string& peer) {
  BoundedAcceptor* const acceptor = ending_;
  if (acceptor == nullptr) return;
  acceptor->end(connection_name(peer));
  const Time now = std::chrono::steady_clock::now();
  if (now - told_at_.exchange(now) >= kSilence) {
    spdlog::warn("a connection was ended that opened and reset calls faster than the server can take them peer={}",
                 peer);
  }
}

void GrpcPort::give_to_grpc(Socket connection) {
  const int yes = 1;  // the end of a message waits for no acknowledgment
  setsockopt(connection.descriptor(), IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
  Entry::NewConnectionParameters parameters;
  parameters.fd = connection.release();
  entry_->HandleNewConnection(&parameters);
}

}  // namespace segserve::server
