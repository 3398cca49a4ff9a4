// SPDX-License-Identifier: Apache-2.0
// Asks a server that is not there: the client library is linked whole, and says so.
#include "segserve/client/client.hpp"

#include <cstdio>
#include <string>

#include "segserve/v1/segmentation_service.pb.h"
#include "segserve/wire/error_details.hpp"

int main() {
  const auto client = segserve::client::Client::connect({.address = "127.0.0.1:1"});
  if (!client.ok()) return 1;
  const absl::Status status = client->health();
  std::printf("%s\n", status.ToString().c_str());
  if (!absl::IsUnavailable(status)) return 1;
  if (segserve::wire::details_of(status).reason != segserve::wire::ErrorReason::kUnspecified) return 1;
  return client->server_info().ok() ? 1 : 0;
}
