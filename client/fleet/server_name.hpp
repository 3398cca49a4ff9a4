// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

// The addresses of servers as users write them.
namespace segserve::client {

/// Splits a list at its commas: "a:1, b:2" holds two addresses. A host without a port gets the default one, 50051.
/// INVALID_ARGUMENT if there is no address, or one of them is empty, a URL, or has no number as its port.
absl::StatusOr<std::vector<std::string>> parse_addresses(std::string_view text);

/// A host by name, which may have several addresses.
struct HostName {
  std::string host;
  std::string port;
  bool operator==(const HostName&) const = default;
};

/// The name in an address ("segserve:50051", "dns:///segserve:50051") whose own addresses are looked up here. Nothing
/// for addresses that stand for one server as they are: IP addresses, localhost, and names that only gRPC understands.
std::optional<HostName> name_to_look_up(std::string_view address);

}  // namespace segserve::client
