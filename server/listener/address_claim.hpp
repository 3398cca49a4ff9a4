// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/options/listen_address.hpp"

namespace segserve::server {

/// An address that one server uses at a time. This is about the paths of unix sockets: gRPC would take one away from
/// whoever has it, and remove whatever socket is there when it closes. So gRPC binds a path of its own, which is then
/// moved. The port of a TCP address is left to gRPC.
///
///     ASSIGN_OR_RETURN(auto claim, AddressClaim::take(address));
///     ...  // gRPC binds claim.bind_address()
///     RETURN_IF_ERROR(claim.publish());
///     ...  // clients connect to the address
///     claim.release();
class AddressClaim {
 public:
  /// Removes a socket that a dead server has left at the path. From here until the path is published, another server
  /// that claims a path of the same folder waits. UNAVAILABLE if a process serves at the path, if there is something
  /// else than a socket, or if the folder cannot be used.
  static absl::StatusOr<AddressClaim> take(const ListenAddress& address);

  AddressClaim(AddressClaim&& other) noexcept;
  AddressClaim& operator=(AddressClaim&&) = delete;
  ~AddressClaim();

  /// The address to bind. For a unix socket it is a path in the same folder that nobody else uses.
  const std::string& bind_address() const { return bind_address_; }
  /// Gives the socket its path. UNAVAILABLE if that fails.
  absl::Status publish();
  /// Removes the path if it still leads to this server's socket, which must be open.
  void release() const;

 private:
  AddressClaim() = default;

  std::string bind_address_;
  std::string path_;  // the next are of unix sockets only
  std::string bind_path_;
  int lock_ = -1;     // a descriptor of the folder; -1 when it is not locked
  dev_t device_ = 0;  // these two identify the socket, once it is published
  ino_t inode_ = 0;
};

}  // namespace segserve::server
