#pragma once

#include "segserve/v1/segmentation_service.pb.h"
#include "server/options/server_options.hpp"

namespace segserve::server {

/// What GetServerInfo answers for these options; `workers` is the number that really runs.
v1::GetServerInfoResponse server_info(const ServerOptions& options, std::size_t workers);

}  // namespace segserve::server
