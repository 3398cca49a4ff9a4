// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/caller_of.hpp"

#include <utility>

namespace segserve::server {

Caller caller_of(const grpc::CallbackServerContext& context, std::string subject) {
  Caller caller{.peer = context.peer(), .subject = std::move(subject)};
  const auto& metadata = context.client_metadata();
  const auto traceparent = metadata.find("traceparent");
  if (traceparent != metadata.end() && traceparent->second.size() <= kMostTraceparentBytes) {
    caller.traceparent.assign(traceparent->second.data(), traceparent->second.size());
  }
  return caller;
}

}  // namespace segserve::server
