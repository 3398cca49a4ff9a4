// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/fleet/server_list.hpp"
#include "client/fleet/server_name.hpp"

namespace segserve::client {

/// An address of a host.
struct HostAddress {
  enum class Family { kIpv4, kIpv6 } family = Family::kIpv4;
  std::string text;  ///< such as "10.0.0.7" or "fe80::1%eth0"
  auto operator<=>(const HostAddress&) const = default;
};

/// Keeps the list of servers as answers to the lookups of their names come. Knows neither DNS nor clock.
///
/// Every address of a name is a server. Of a name with addresses of both families those of the first one's family
/// count, because each of its servers is likely to have one of either, and systems put first what they can reach. A
/// name with one address of each family is one server, for which gRPC tries both.
class ServerDirectory {
 public:
  /// `addresses` as of parse_addresses. `looks_up` false: all of them are left to gRPC.
  ServerDirectory(const std::vector<std::string>& addresses, bool looks_up);

  /// The names that have to be looked up.
  const std::vector<HostName>& names() const { return names_; }
  /// Takes the answer for names()[name]. One without addresses, or an error, leaves known servers as they are. Returns
  /// whether the list is another one now.
  bool update(std::size_t name, const absl::StatusOr<std::vector<HostAddress>>& answer);
  const ServerList& list() const { return list_; }

 private:
  struct Entry {
    std::string address;              // as it was given
    std::optional<std::size_t> name;  // index; unset: it is one server
    std::vector<Server> servers = {};
    absl::Status trouble = {};
  };
  void rebuild();

  std::vector<HostName> names_;
  std::vector<Entry> entries_;
  ServerId last_id_ = 0;
  ServerList list_;
};

}  // namespace segserve::client
