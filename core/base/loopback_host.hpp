// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace segserve {

/// Whether a host can be reached by this machine only: "localhost", in any case, an address of 127.0.0.0/8, or ::1
/// without brackets. A name such as 127.example is none of them. Names are not looked up.
bool is_loopback_host(std::string host);

}  // namespace segserve
