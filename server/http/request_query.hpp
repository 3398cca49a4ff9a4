// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace segserve::server {

/// A text with %XX and + decoded, as in the query of a URL; nullopt if an escape is broken.
std::optional<std::string> decode_query_text(std::string_view text);

/// The parameters of a query such as "threshold=0.5&outputs=labels", decoded and in their order; nullopt if an escape
/// is broken. A parameter without "=" has an empty value.
std::optional<std::vector<std::pair<std::string, std::string>>> parse_query(std::string_view query);

}  // namespace segserve::server
