// SPDX-License-Identifier: Apache-2.0
#include "server/config/environment.hpp"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <optional>

#include "command_line/closest_name.hpp"
#include "fmt/format.h"

namespace segserve::server {
namespace {

constexpr std::string_view kPrefix = "SEGSERVE_";
// segctl and the tests read this one.
constexpr std::string_view kDataFolder = "SEGSERVE_DATA_DIR";

/// SEGSERVE_SERVICE_HOST, SEGSERVE_PORT=tcp://10.0.0.1:50051, SEGSERVE_PORT_50051_TCP_PROTO and their like.
bool is_of_kubernetes(std::string_view name, std::string_view value) {
  return name.find("_SERVICE_HOST") != std::string_view::npos || name.find("_SERVICE_PORT") != std::string_view::npos ||
         name.find("_TCP") != std::string_view::npos || name.find("_UDP") != std::string_view::npos ||
         value.starts_with("tcp://") || value.starts_with("udp://");
}

}  // namespace

Environment process_environment() {
  Environment environment;
  for (char** each = environ; each != nullptr && *each != nullptr; ++each) {
    const std::string_view entry(*each);
    const std::size_t equals = entry.find('=');
    if (equals != std::string_view::npos) environment.emplace(entry.substr(0, equals), entry.substr(equals + 1));
  }
  return environment;
}

std::string variable_of(std::string_view option) {
  std::string variable(kPrefix);
  for (const unsigned char c : option) variable += c == '-' ? '_' : static_cast<char>(std::toupper(c));
  return variable;
}

std::vector<std::string> unknown_variables(const Environment& environment, std::span<const std::string> options) {
  std::vector<std::string> known(options.size());
  std::ranges::transform(options, known.begin(),
                         [](std::string_view option) { return variable_of(option).substr(kPrefix.size()); });
  std::vector<std::string> warnings;
  for (const auto& [name, value] : environment) {
    const bool is_ours = name.starts_with(kPrefix) && name != kDataFolder && !is_of_kubernetes(name, value);
    if (!is_ours) continue;
    const std::string rest = name.substr(kPrefix.size());
    if (std::ranges::find(known, rest) != known.end()) continue;
    const std::optional<std::string> meant = closest_name(rest, known);
    const std::string hint = meant ? fmt::format(" (did you mean {}{}?)", kPrefix, *meant) : "";
    warnings.push_back(fmt::format("the variable {} sets nothing{}", name, hint));
  }
  return warnings;
}

}  // namespace segserve::server
