// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/proofs_of.hpp"

#include <memory>
#include <string>

#include "grpc/grpc_security_constants.h"
#include "grpcpp/security/auth_context.h"

namespace segserve::server {
namespace {

/// The name of the certificate that TLS has verified: its first URI, or else DNS name, or else common name. Empty if
/// the client has shown none.
std::string certificate_name(const grpc::CallbackServerContext& context) {
  const std::shared_ptr<const grpc::AuthContext> peer = context.auth_context();
  if (!peer || !peer->IsPeerAuthenticated()) return "";
  for (const char* property : {GRPC_PEER_URI_PROPERTY_NAME, GRPC_PEER_DNS_PROPERTY_NAME, GRPC_X509_CN_PROPERTY_NAME}) {
    for (const grpc::string_ref& value : peer->FindPropertyValues(property)) {
      if (!value.empty()) return {value.data(), value.size()};
    }
  }
  return "";
}

}  // namespace

PresentedProofs proofs_of(const grpc::CallbackServerContext& context) {
  PresentedProofs proofs{.certificate_name = certificate_name(context)};
  const auto [begin, end] = context.client_metadata().equal_range("authorization");
  for (auto header = begin; header != end; ++header) {
    proofs.authorizations.emplace_back(header->second.data(), header->second.size());
  }
  return proofs;
}

}  // namespace segserve::server
