// SPDX-License-Identifier: Apache-2.0
#include "server/tls/certificate_reloader.hpp"

#include <chrono>
#include <thread>

#include "gtest/gtest.h"
#include "test/tls/test_certificates.hpp"

namespace segserve::server {
namespace {

using std::chrono::milliseconds;
using tls::make_identity, tls::write_test_file;

/// Waits until the reloader has found new files right or wrong.
TlsStatus status_after_change(const CertificateReloader& reloader, std::uint64_t reloads_before) {
  TlsStatus status = reloader.status();
  for (int i = 0; i < 3000 && status.reloads + status.failed_reloads == reloads_before; ++i) {
    std::this_thread::sleep_for(milliseconds(10));
    status = reloader.status();
  }
  return status;
}

TEST(CertificateReloader, CountsWhatItTakesAndWhatItRefuses) {
  const tls::TestIdentity first = make_identity("first", nullptr, std::chrono::hours(1));
  const tls::TestIdentity second = make_identity("second", nullptr, std::chrono::hours(99));
  const tls::TlsFiles files{.certificate = write_test_file("a.crt", first.certificate_pem()),
                            .key = write_test_file("a.key", first.key_pem()),
                            .authorities = ""};
  const auto reloader = CertificateReloader::start(files, milliseconds(5));
  ASSERT_TRUE(reloader.ok()) << reloader.status();
  const TlsStatus before = (*reloader)->status();
  const auto identity = (*reloader)->identity();
  EXPECT_EQ(before.reloads + before.failed_reloads, 0U);
  EXPECT_FALSE(before.client_ca_end);

  write_test_file("a.crt", second.certificate_pem());
  const TlsStatus refused = status_after_change(**reloader, 0);
  EXPECT_EQ(refused.failed_reloads, 1U);
  EXPECT_EQ(refused.certificate_end, before.certificate_end);
  EXPECT_EQ((*reloader)->identity(), identity);

  write_test_file("a.key", second.key_pem());
  const TlsStatus taken = status_after_change(**reloader, 1);
  EXPECT_EQ(taken.reloads, 1U);
  EXPECT_GT(taken.certificate_end, before.certificate_end + std::chrono::hours(90));
  EXPECT_EQ((*reloader)->identity()->contents.key, second.key_pem());
}

}  // namespace
}  // namespace segserve::server
