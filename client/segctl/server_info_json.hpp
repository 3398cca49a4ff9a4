// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nlohmann/json_fwd.hpp"
#include "segserve/client/client.hpp"

namespace segserve::segctl {

/// Writes the abilities and limits of a server as JSON, with the names of the command line.
nlohmann::ordered_json server_info_json(const client::ServerInfo& info);

}  // namespace segserve::segctl
