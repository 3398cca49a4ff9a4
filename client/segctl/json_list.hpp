// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "nlohmann/json.hpp"

namespace segserve::segctl {

/// The list of this name in a file that holds a JSON object with nothing else. INVALID_ARGUMENT, with the path, for
/// text that is no JSON, with its line and column; for objects that have a member twice; for other members; and if
/// there is no such list or it is empty.
absl::StatusOr<nlohmann::ordered_json> read_json_list(const std::string& path, std::string_view name);

/// INVALID_ARGUMENT if something is no object, or has a member that is not among these.
absl::Status check_members(const nlohmann::ordered_json& json, std::initializer_list<std::string_view> names);

}  // namespace segserve::segctl
