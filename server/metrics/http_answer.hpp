// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace segserve::server {

/// The most bytes of a request.
inline constexpr std::size_t kMostRequestBytes = 8192;

/// The whole answer of an HTTP/1.1 server that has one page, /metrics, to a request of which these bytes have come.
/// nullopt if the request may go on. `page` is called only if the page is asked for; without a page, the answer is
/// 429 (Too Many Requests). The connection is to be closed after the answer.
std::optional<std::string> http_answer(std::string_view received,
                                       const std::function<std::optional<std::string>()>& page);

}  // namespace segserve::server
