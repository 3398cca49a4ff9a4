// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "tls/tls_reload.hpp"

namespace segserve::client {

/// The settings of TLS for one connection of a client.
struct ClientTls {
  tls::TlsFiles files;
  std::shared_ptr<const tls::TlsIdentity> identity;  ///< what the files held; never null
  std::string server_name;                           ///< as in TlsOptions
};

}  // namespace segserve::client
