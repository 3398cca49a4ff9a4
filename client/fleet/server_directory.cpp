// SPDX-License-Identifier: Apache-2.0
#include "client/fleet/server_directory.hpp"

#include <algorithm>
#include <utility>

#include "fmt/format.h"

namespace segserve::client {
namespace {

using Family = HostAddress::Family;

/// In a target of gRPC, which is a URI, the zone of an IPv6 address follows "%25".
std::string with_escaped_zone(std::string text) {
  if (const std::size_t percent = text.find('%'); percent != std::string::npos) text.replace(percent, 1, "%25");
  return text;
}

Server server_at(const HostAddress& address, const HostName& name) {
  Server server{.authority = fmt::format("{}:{}", name.host, name.port)};
  if (address.family == Family::kIpv4) {
    server.address = fmt::format("{}:{}", address.text, name.port);
    server.target = "ipv4:" + server.address;
  } else {
    server.address = fmt::format("[{}]:{}", address.text, name.port);
    server.target = fmt::format("ipv6:[{}]:{}", with_escaped_zone(address.text), name.port);
  }
  return server;
}

/// One server that has an address of each family. gRPC looks up its name again, which is done for a new channel.
Server server_at_both(const HostName& name) {
  const std::string address = fmt::format("{}:{}", name.host, name.port);
  return {.target = "dns:///" + address, .authority = address, .address = address};
}

std::vector<Server> servers_at(const std::vector<HostAddress>& addresses, const HostName& name) {
  const auto in_family = [&](Family family) { return std::ranges::count(addresses, family, &HostAddress::family); };
  const auto ipv4 = in_family(Family::kIpv4), ipv6 = in_family(Family::kIpv6);
  if (ipv4 == 1 && ipv6 == 1) return {server_at_both(name)};
  std::vector<Server> servers;
  for (const HostAddress& address : addresses) {
    if (address.family == addresses.front().family) servers.push_back(server_at(address, name));
  }
  std::ranges::sort(servers, {}, &Server::target);
  const auto repeated = std::ranges::unique(servers, {}, &Server::target);
  servers.erase(repeated.begin(), repeated.end());
  return servers;
}

}  // namespace

ServerDirectory::ServerDirectory(const std::vector<std::string>& addresses, bool looks_up) {
  for (const std::string& address : addresses) {
    Entry& entry = entries_.emplace_back(Entry{.address = address, .name = std::nullopt});
    auto name = looks_up ? name_to_look_up(address) : std::nullopt;
    if (name) {
      entry.name = names_.size();
      names_.push_back(*std::move(name));
    } else {
      entry.servers.push_back({.id = ++last_id_, .target = address, .authority = "", .address = address});
    }
  }
  rebuild();
}

bool ServerDirectory::update(std::size_t name, const absl::StatusOr<std::vector<HostAddress>>& answer) {
  const auto entry = std::ranges::find(entries_, std::optional(name), &Entry::name);
  const bool has_addresses = answer.ok() && !answer->empty();
  if (!has_addresses) {
    if (!entry->servers.empty()) return false;
    const bool is_news = entry->trouble.ok();
    entry->trouble = answer.ok() ? absl::UnavailableError(fmt::format("{} has no address", entry->address))
                                 : absl::UnavailableError(fmt::format("{} is not known: {}", entry->address,
                                                                      std::string(answer.status().message())));
    rebuild();
    return is_news;
  }
  std::vector<Server> servers = servers_at(*answer, names_[name]);
  if (std::ranges::equal(servers, entry->servers, {}, &Server::target, &Server::target)) return false;
  for (Server& server : servers) {
    const auto known = std::ranges::find(entry->servers, server.target, &Server::target);
    server.id = known == entry->servers.end() ? ++last_id_ : known->id;
  }
  entry->servers = std::move(servers);
  entry->trouble = absl::OkStatus();
  rebuild();
  return true;
}

void ServerDirectory::rebuild() {
  list_ = {};
  for (const Entry& entry : entries_) {
    list_.servers.insert(list_.servers.end(), entry.servers.begin(), entry.servers.end());
    list_.trouble.Update(entry.trouble);
  }
}

}  // namespace segserve::client
