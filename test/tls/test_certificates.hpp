// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>

#include "gtest/gtest.h"
#include "openssl/pem.h"
#include "openssl/x509v3.h"
#include "tls/openssl_pointers.hpp"

namespace segserve::tls {

/// A certificate and its key, made for a test.
struct TestIdentity {
  X509Pointer certificate;
  KeyPointer key;

  std::string certificate_pem() const {
    return pem_of([this](BIO* out) { return PEM_write_bio_X509(out, certificate.get()); });
  }
  std::string key_pem(const char* passphrase = nullptr) const {
    const EVP_CIPHER* cipher = passphrase == nullptr ? nullptr : EVP_aes_128_cbc();
    return pem_of([&](BIO* out) {
      return PEM_write_bio_PKCS8PrivateKey(out, key.get(), cipher, passphrase, passphrase ? 4 : 0, nullptr, nullptr);
    });
  }

 private:
  template <typename Write>
  static std::string pem_of(Write write) {
    const BioPointer out(BIO_new(BIO_s_mem()));
    EXPECT_EQ(write(out.get()), 1);
    char* text = nullptr;
    const long length = BIO_get_mem_data(out.get(), &text);
    return std::string(text, static_cast<std::size_t>(length));
  }
};

/// Makes a certificate for localhost and 127.0.0.1, signed by `authority`, or by itself as an authority if that is
/// null. It is valid from an hour before its end or the present, whichever is earlier.
inline TestIdentity make_identity(const std::string& name, const TestIdentity* authority = nullptr,
                                  std::chrono::seconds lifetime = std::chrono::hours(1)) {
  static long serial = 0;
  TestIdentity made{X509Pointer(X509_new()), KeyPointer(EVP_EC_gen("P-256"))};
  X509* certificate = made.certificate.get();
  X509_set_version(certificate, X509_VERSION_3);
  ASN1_INTEGER_set(X509_get_serialNumber(certificate), ++serial);
  X509_gmtime_adj(X509_getm_notBefore(certificate), std::min(0L, static_cast<long>(lifetime.count())) - 3600);
  X509_gmtime_adj(X509_getm_notAfter(certificate), static_cast<long>(lifetime.count()));
  X509_set_pubkey(certificate, made.key.get());
  X509_NAME_add_entry_by_txt(X509_get_subject_name(certificate), "CN", MBSTRING_UTF8,
                             reinterpret_cast<const unsigned char*>(name.c_str()), -1, -1, 0);
  X509* issuer = authority == nullptr ? certificate : authority->certificate.get();
  X509_set_issuer_name(certificate, X509_get_subject_name(issuer));
  X509V3_CTX context;
  X509V3_set_ctx(&context, issuer, certificate, nullptr, nullptr, 0);
  const int kind = authority == nullptr ? NID_basic_constraints : NID_subject_alt_name;
  X509_EXTENSION* extension =
      X509V3_EXT_conf_nid(nullptr, &context, kind, authority == nullptr ? "CA:TRUE" : "DNS:localhost,IP:127.0.0.1");
  X509_add_ext(certificate, extension, -1);
  X509_EXTENSION_free(extension);
  EXPECT_GT(X509_sign(certificate, authority == nullptr ? made.key.get() : authority->key.get(), EVP_sha256()), 0);
  return made;
}

/// Writes a file into a folder of this test's own, in one step, and returns its path.
inline std::string write_test_file(const std::string& name, const std::string& content) {
  const auto* test = testing::UnitTest::GetInstance()->current_test_info();
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / (std::string(test->test_suite_name()) + "." + test->name());
  std::filesystem::create_directories(folder);
  std::ofstream(folder / (name + ".new"), std::ios::binary) << content;
  std::filesystem::rename(folder / (name + ".new"), folder / name);
  return folder / name;
}

}  // namespace segserve::tls
