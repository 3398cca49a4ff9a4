// SPDX-License-Identifier: Apache-2.0
#include "server/options/host_name.hpp"

#include <algorithm>
#include <cstddef>
#include <optional>

#include "absl/strings/ascii.h"
#include "core/base/loopback_host.hpp"
#include "fmt/format.h"

namespace segserve::server {
namespace {

constexpr std::size_t kMostNameBytes = 253;  // of a name in the DNS

std::string in_small_letters(std::string_view text) {
  std::string small(text);
  std::ranges::transform(small, small.begin(),
                         [](char c) { return absl::ascii_tolower(static_cast<unsigned char>(c)); });
  return small;
}

bool is_digit(char c) { return absl::ascii_isdigit(static_cast<unsigned char>(c)); }

bool is_name_character(char c) {
  return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '.' || c == '-' || c == '_';
}

bool is_address_character(char c) {
  return absl::ascii_isxdigit(static_cast<unsigned char>(c)) || c == ':' || c == '.';
}

/// Whether a text may stand in a header Host before the port.
bool is_host_name(std::string_view text) {
  if (text.starts_with('[') && text.ends_with(']') && text.size() > 2) {
    return std::ranges::all_of(text.substr(1, text.size() - 2), is_address_character);
  }
  return !text.empty() && text.size() <= kMostNameBytes && std::ranges::all_of(text, is_name_character);
}

/// The name in a header Host, without its port but with the brackets of an IPv6 address; nullopt if it has none.
std::optional<std::string_view> name_in(std::string_view host) {
  const std::size_t bracket = host.find(']');
  const std::size_t colon = host.find(':', bracket == std::string_view::npos ? 0 : bracket);
  const std::string_view name = host.substr(0, colon);
  const std::string_view port = host.substr(name.size());
  if (!is_host_name(name) || !std::ranges::all_of(port.substr(port.empty() ? 0 : 1), is_digit)) return std::nullopt;
  return name;
}

std::string_view without_spaces(std::string_view text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  while (text.ends_with(' ')) text.remove_suffix(1);
  return text;
}

}  // namespace

absl::StatusOr<std::vector<std::string>> parse_host_names(std::string_view list) {
  std::vector<std::string> names;
  while (!list.empty()) {
    const std::size_t end = std::min(list.find(','), list.size());
    const std::string_view name = without_spaces(list.substr(0, end));
    if (!is_host_name(name)) {
      return absl::InvalidArgumentError(
          fmt::format("'{}' is no name of a host; give names such as robot.example, without scheme and port", name));
    }
    names.push_back(in_small_letters(name));
    list.remove_prefix(std::min(end + 1, list.size()));
  }
  return names;
}

bool is_host_allowed(std::string_view host, const std::vector<std::string>& names) {
  const auto found = name_in(host);
  if (!found) return false;
  std::string name = in_small_letters(*found);
  if (std::ranges::find(names, name) != names.end()) return true;
  return is_loopback_host(name.starts_with('[') ? name.substr(1, name.size() - 2) : name);
}

}  // namespace segserve::server
