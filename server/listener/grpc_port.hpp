// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "grpcpp/security/server_credentials.h"
#include "grpcpp/server_builder.h"
#include "server/listener/bounded_acceptor.hpp"
#include "server/listener/call_flood.hpp"
#include "server/listener/socket.hpp"
#include "server/options/listen_address.hpp"

namespace segserve::server {

/// A port whose connections are accepted here and then given to gRPC. gRPC 1.51 does not listen itself, because it
/// would accept no connections any more once it has found no file descriptor for one (CVE-2023-4785), and because it
/// cannot end a connection that floods it with calls (CVE-2023-44487): such a connection is ended here, and new ones of
/// its address wait until its calls are gone.
///
///     ASSIGN_OR_RETURN(auto port, GrpcPort::open(address, builder, credentials));
///     auto server = builder.BuildAndStart();
///     RETURN_IF_ERROR(port->start(most));
///     ...  // clients connect
///     port->close();
///     server->Shutdown();
class GrpcPort {
 public:
  /// Listens where gRPC would: at every address of a host, and for all addresses of IPv4 at those of IPv6, too.
  /// UNAVAILABLE if none can be bound.
  static absl::StatusOr<std::unique_ptr<GrpcPort>> open(const ListenAddress& address, grpc::ServerBuilder& builder,
                                                        std::shared_ptr<grpc::ServerCredentials> credentials);

  /// Begins to accept connections, at most so many at a time; see BoundedAcceptor. UNAVAILABLE if there are too many
  /// open files.
  absl::Status start(std::size_t most);

  /// Accepts no more connections.
  void close() {
    if (acceptor_) acceptor_->close();
  }

  int port() const { return port_; }
  /// The number of connections that were accepted so far.
  std::uint64_t accepted() const { return acceptor_->accepted(); }

 private:
  using Time = std::chrono::steady_clock::time_point;
  using Entry = grpc::experimental::ExternalConnectionAcceptor;

  explicit GrpcPort(std::vector<Socket> listeners);

  void give_to_grpc(Socket connection);
  /// Ends a connection that floods the server with calls.
  void end(const std::string& peer);

  const int port_;
  std::vector<Socket> listeners_;  // until `start`
  std::unique_ptr<Entry> entry_;
  CallFlood flood_;
  std::atomic<Time> told_at_{Time()};              // in the log
  std::unique_ptr<BoundedAcceptor> acceptor_;      // is destroyed before the entry that it gives connections to
  std::atomic<BoundedAcceptor*> ending_{nullptr};  // for threads of gRPC, which come before `start` has returned
};

}  // namespace segserve::server
