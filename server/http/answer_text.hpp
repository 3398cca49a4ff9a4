// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "server/http/http_message.hpp"

namespace segserve::server {

/// The status line and the headers of an answer, with those of the transport, up to the empty line.
std::string answer_header(const HttpAnswer& answer, bool closes);

}  // namespace segserve::server
