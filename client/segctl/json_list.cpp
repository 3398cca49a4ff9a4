// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/json_list.hpp"

#include <algorithm>

#include "client/segctl/input_file.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "core/base/strict_json.hpp"
#include "fmt/format.h"
#include "fmt/ranges.h"

namespace segserve::segctl {
namespace {

using Json = nlohmann::ordered_json;

absl::StatusOr<Json> list_in(const std::string& bytes, std::string_view name) {
  ASSIGN_OR_RETURN(const Json json, parse_strict_json<Json>(bytes));
  RETURN_IF_ERROR(check_members(json, {name}));
  if (!json.contains(name) || !json[name].is_array()) {
    return absl::InvalidArgumentError(fmt::format("it has no list \"{}\"", name));
  }
  if (json[name].empty()) return absl::InvalidArgumentError(fmt::format("its list \"{}\" is empty", name));
  return json[name];
}

}  // namespace

absl::StatusOr<Json> read_json_list(const std::string& path, std::string_view name) {
  ASSIGN_OR_RETURN(const std::string bytes, read_input(path));
  auto list = list_in(bytes, name);
  if (!list.ok()) return with_prefix(path, list.status());
  return list;
}

absl::Status check_members(const Json& json, std::initializer_list<std::string_view> names) {
  if (!json.is_object()) return absl::InvalidArgumentError("it is no JSON object");
  for (const auto& [member, value] : json.items()) {
    if (std::ranges::find(names, member) == names.end()) {
      return absl::InvalidArgumentError(
          fmt::format("it has a member \"{}\", but may only have {}", member, fmt::join(names, ", ")));
    }
  }
  return absl::OkStatus();
}

}  // namespace segserve::segctl
