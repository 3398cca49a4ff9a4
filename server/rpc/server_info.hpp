// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "segserve/v1/segmentation_service.pb.h"
#include "server/options/server_options.hpp"

namespace segserve::server {

/// The answer to GetServerInfo for these options; `workers` is the number that really runs.
v1::GetServerInfoResponse server_info(const ServerOptions& options, std::size_t workers);

}  // namespace segserve::server
