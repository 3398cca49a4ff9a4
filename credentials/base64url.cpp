// SPDX-License-Identifier: Apache-2.0
#include "credentials/base64url.hpp"

#include "absl/strings/escaping.h"

namespace segserve::credentials {

std::string to_base64url(std::string_view bytes) {
  std::string text;
  absl::WebSafeBase64Escape({bytes.data(), bytes.size()}, &text);
  return text;
}

std::optional<std::string> from_base64url(std::string_view text) {
  std::string bytes;
  if (!absl::WebSafeBase64Unescape({text.data(), text.size()}, &bytes)) return std::nullopt;
  // The function of absl also takes other spellings, such as spaces and padding.
  if (to_base64url(bytes) != text) return std::nullopt;
  return bytes;
}

}  // namespace segserve::credentials
