// SPDX-License-Identifier: Apache-2.0
#include "client/stream/liveness_probe.hpp"

#include <utility>

namespace segserve::client {

void LivenessProbe::start(std::chrono::milliseconds timeout, std::function<void(bool alive)> done) {
  context_.set_deadline(std::chrono::system_clock::now() + timeout);
  stub_.async()->GetServerInfo(&context_, &request_, &response_, [done = std::move(done)](const grpc::Status& status) {
    done(status.ok() || status.error_code() == grpc::StatusCode::UNAUTHENTICATED);
  });
}

}  // namespace segserve::client
