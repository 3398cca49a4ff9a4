// SPDX-License-Identifier: Apache-2.0
#include "credentials/new_token.hpp"

#include <openssl/rand.h>

#include <string_view>

#include "credentials/base64url.hpp"

namespace segserve::credentials {

absl::StatusOr<std::string> new_token() {
  unsigned char bytes[32];
  if (RAND_priv_bytes(bytes, sizeof(bytes)) != 1) return absl::UnavailableError("the system gives no random bits");
  return "segserve_" + to_base64url({reinterpret_cast<const char*>(bytes), sizeof(bytes)});
}

}  // namespace segserve::credentials
