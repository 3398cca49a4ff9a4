// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace segserve::tls {

/// Why OpenSSL failed last on this thread, e.g. "bad base64 decode". Forgets all of its errors, which would otherwise
/// be taken for those of the next function.
std::string take_openssl_error();

}  // namespace segserve::tls
