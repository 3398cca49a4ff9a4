// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace segserve::server {

/// Variables of the environment by name.
using Environment = std::map<std::string, std::string>;

/// The environment of this process.
Environment process_environment();

/// The variable that sets an option: "queue-bytes" is SEGSERVE_QUEUE_BYTES.
std::string variable_of(std::string_view option);

/// A warning for each variable that begins with SEGSERVE_ but sets none of the options: it may be misspelled.
/// Kubernetes makes variables for a Service of the name segserve, which are left out.
std::vector<std::string> unknown_variables(const Environment& environment, std::span<const std::string> options);

}  // namespace segserve::server
