// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace segserve::credentials {

/// RFC 4648, section 5, without padding, as JSON Web Tokens have it.
std::string to_base64url(std::string_view bytes);

/// nullopt unless the text is exactly what to_base64url makes of some bytes: without padding, spaces, or bits too many.
std::optional<std::string> from_base64url(std::string_view text);

}  // namespace segserve::credentials
