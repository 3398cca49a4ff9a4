// SPDX-License-Identifier: Apache-2.0
#include "server/access/client_share.hpp"

#include "server/scheduling/client_address.hpp"

namespace segserve::server {

ClientShare share_of(const std::string& subject, const std::string& peer, const std::string& part) {
  if (subject.empty()) return {.client = part, .flow = "", .owner = {client_address(peer), part}};
  const std::string name = "subject " + subject;  // which is no address
  return {.client = name, .flow = part, .owner = {name, part}};
}

}  // namespace segserve::server
