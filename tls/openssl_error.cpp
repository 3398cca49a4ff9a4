// SPDX-License-Identifier: Apache-2.0
#include "tls/openssl_error.hpp"

#include "openssl/err.h"

namespace segserve::tls {

std::string take_openssl_error() {
  const char* reason = ERR_reason_error_string(ERR_peek_last_error());
  ERR_clear_error();
  return reason != nullptr ? reason : "unknown error of OpenSSL";
}

}  // namespace segserve::tls
