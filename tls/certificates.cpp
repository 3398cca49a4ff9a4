// SPDX-License-Identifier: Apache-2.0
#include "tls/certificates.hpp"

#include <arpa/inet.h>

#include <algorithm>
#include <array>
#include <ctime>

#include "fmt/chrono.h"
#include "fmt/format.h"
#include "openssl/err.h"
#include "openssl/pem.h"
#include "openssl/x509v3.h"
#include "tls/openssl_error.hpp"

namespace segserve::tls {
namespace {

BioPointer reader_of(std::string_view text) {
  return BioPointer(BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
}

/// Returns the text that was written, cut if it is long.
std::string content_of(BIO& writer) {
  constexpr std::size_t kMostBytes = 200;
  char* text = nullptr;
  const long length = BIO_get_mem_data(&writer, &text);
  return std::string(text, std::min(static_cast<std::size_t>(std::max(length, 0L)), kMostBytes));
}

/// Gives no passphrase. Without this function OpenSSL would ask for one on the terminal.
int no_passphrase(char* /*buffer*/, int /*size*/, int /*writing*/, void* asked) {
  *static_cast<bool*>(asked) = true;
  return -1;
}

std::chrono::sys_seconds time_of(const ASN1_TIME* time) {
  std::tm parts{};
  if (ASN1_TIME_to_tm(time, &parts) != 1) return {};
  return std::chrono::sys_seconds(std::chrono::seconds(timegm(&parts)));
}

/// Escapes control characters.
std::string text_of(const ASN1_STRING& string) {
  const BioPointer writer(BIO_new(BIO_s_mem()));
  ASN1_STRING_print_ex(writer.get(), &string, ASN1_STRFLGS_RFC2253);
  return content_of(*writer);
}

/// An address of IPv4 or IPv6 from its 4 or 16 bytes.
std::string address_of(const ASN1_OCTET_STRING& bytes) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  const int length = ASN1_STRING_length(&bytes);
  if (length != 4 && length != 16) return "an address of unknown kind";
  inet_ntop(length == 4 ? AF_INET : AF_INET6, ASN1_STRING_get0_data(&bytes), text.data(), text.size());
  return text.data();
}

}  // namespace

absl::StatusOr<std::vector<X509Pointer>> parse_certificates(std::string_view pem) {
  const BioPointer reader = reader_of(pem);
  std::vector<X509Pointer> certificates;
  ERR_clear_error();
  while (X509* certificate = PEM_read_bio_X509(reader.get(), nullptr, nullptr, nullptr)) {
    certificates.emplace_back(certificate);
  }
  const bool at_end = ERR_GET_REASON(ERR_peek_last_error()) == PEM_R_NO_START_LINE;
  const std::string error = take_openssl_error();
  if (!at_end) {
    return absl::InvalidArgumentError(fmt::format("certificate {} is damaged ({})", certificates.size() + 1, error));
  }
  if (certificates.empty()) return absl::InvalidArgumentError("there is no certificate in PEM");
  return certificates;
}

absl::StatusOr<KeyPointer> parse_key(std::string_view pem) {
  bool is_encrypted = false;
  ERR_clear_error();
  KeyPointer key(PEM_read_bio_PrivateKey(reader_of(pem).get(), nullptr, no_passphrase, &is_encrypted));
  if (key) return key;
  const std::string error = take_openssl_error();
  if (is_encrypted) return absl::InvalidArgumentError("the private key is encrypted, and nobody is there to ask");
  return absl::InvalidArgumentError(fmt::format("there is no private key in PEM that can be read ({})", error));
}

absl::Status check_pair(const std::vector<X509Pointer>& chain, EVP_PKEY& key) {
  ERR_clear_error();
  if (X509_check_private_key(chain.front().get(), &key) != 1) {
    ERR_clear_error();
    return absl::InvalidArgumentError("the private key does not belong to the certificate");
  }
  const SslContextPointer context(SSL_CTX_new(TLS_method()));
  bool is_usable = SSL_CTX_use_certificate(context.get(), chain.front().get()) == 1 &&
                   SSL_CTX_use_PrivateKey(context.get(), &key) == 1;
  for (std::size_t i = 1; i < chain.size(); ++i) {
    is_usable = is_usable && SSL_CTX_add1_chain_cert(context.get(), chain[i].get()) == 1;
  }
  if (is_usable) return absl::OkStatus();
  return absl::InvalidArgumentError(fmt::format("TLS cannot use the certificate ({})", take_openssl_error()));
}

Validity validity_of(const X509& certificate) {
  return {.begin = time_of(X509_get0_notBefore(&certificate)), .end = time_of(X509_get0_notAfter(&certificate))};
}

Validity validity_of(const std::vector<X509Pointer>& certificates) {
  Validity all = validity_of(*certificates.front());
  for (const X509Pointer& certificate : certificates) {
    const Validity one = validity_of(*certificate);
    all = {.begin = std::max(all.begin, one.begin), .end = std::min(all.end, one.end)};
  }
  return all;
}

std::vector<std::string> names_of(const X509& certificate) {
  constexpr int kMostNames = 5;
  std::vector<std::string> names;
  const NamesPointer list(
      static_cast<GENERAL_NAMES*>(X509_get_ext_d2i(&certificate, NID_subject_alt_name, nullptr, nullptr)));
  for (int i = 0; i < std::min(sk_GENERAL_NAME_num(list.get()), kMostNames); ++i) {
    const GENERAL_NAME* name = sk_GENERAL_NAME_value(list.get(), i);
    if (name->type == GEN_DNS) names.push_back(text_of(*name->d.dNSName));
    if (name->type == GEN_IPADD) names.push_back(address_of(*name->d.iPAddress));
  }
  if (names.empty()) names.push_back(text_of(X509_get_subject_name(&certificate)));
  return names;
}

std::string text_of(const X509_NAME* name) {
  const BioPointer writer(BIO_new(BIO_s_mem()));
  X509_NAME_print_ex(writer.get(), name, 0, XN_FLAG_RFC2253);
  return content_of(*writer);
}

std::string text_of(std::chrono::sys_seconds time) {
  return fmt::format("{:%Y-%m-%d %H:%M:%S} UTC", fmt::gmtime(time.time_since_epoch().count()));
}

}  // namespace segserve::tls
