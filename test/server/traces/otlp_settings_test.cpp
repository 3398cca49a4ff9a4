// SPDX-License-Identifier: Apache-2.0
#include "server/traces/otlp_settings.hpp"

#include <algorithm>
#include <cstdlib>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace segserve::server {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::Pair;

/// Leaves the environment without OpenTelemetry's variables.
class OtlpSettingsTest : public testing::Test {
 protected:
  OtlpSettingsTest() { clear(); }
  ~OtlpSettingsTest() override { clear(); }

  static void clear() {
    for (const char* name : {"OTEL_SERVICE_NAME", "OTEL_RESOURCE_ATTRIBUTES", "OTEL_EXPORTER_OTLP_HEADERS",
                             "OTEL_EXPORTER_OTLP_CERTIFICATE"}) {
      unsetenv(name);
    }
  }

  static std::string text_of(const OtlpSettings& settings, const std::string& key) {
    const auto found = std::ranges::find(settings.resource, key, &SpanAttribute::key);
    return found == settings.resource.end() ? "" : std::get<std::string>(found->value);
  }
};

TEST_F(OtlpSettingsTest, TakesUrlsOfHttpOnly) {
  for (const char* good : {"http://127.0.0.1:4318", "https://collector.example/otlp/", "http://[::1]:4318"}) {
    EXPECT_TRUE(check_otlp_endpoint(good).ok()) << good;
  }
  for (const char* bad : {"", "127.0.0.1:4318", "localhost", "ftp://a", "file:///etc/passwd", "http://", "http://a b",
                          "http://user:hunter2@a", "HTTP//x"}) {
    const absl::Status status = check_otlp_endpoint(bad);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << bad;
    EXPECT_THAT(std::string(status.message()), Not(HasSubstr("hunter2")));
  }
}

TEST_F(OtlpSettingsTest, AppendsThePathOfTraces) {
  EXPECT_EQ(otlp_settings("http://127.0.0.1:4318")->url, "http://127.0.0.1:4318/v1/traces");
  EXPECT_EQ(otlp_settings("https://a/otlp/")->url, "https://a/otlp/v1/traces");
}

TEST_F(OtlpSettingsTest, DescribesTheProcess) {
  const auto settings = otlp_settings("http://a");
  EXPECT_EQ(text_of(*settings, "service.name"), "segserve");
  EXPECT_NE(text_of(*settings, "service.version"), "");
  EXPECT_NE(text_of(*settings, "service.instance.id"), "");
}

TEST_F(OtlpSettingsTest, HonorsTheVariablesOfOpenTelemetry) {
  setenv("OTEL_RESOURCE_ATTRIBUTES", "service.name=one, deployment.environment=lab%2Cnorth", 1);
  setenv("OTEL_EXPORTER_OTLP_HEADERS", "authorization=Bearer%20secret,x-tenant = a=b", 1);
  setenv("OTEL_EXPORTER_OTLP_CERTIFICATE", "/etc/ca.pem", 1);
  auto settings = otlp_settings("http://a");
  ASSERT_TRUE(settings.ok()) << settings.status();
  EXPECT_EQ(text_of(*settings, "service.name"), "one");
  EXPECT_EQ(text_of(*settings, "deployment.environment"), "lab,north");
  EXPECT_EQ(settings->ca_file, "/etc/ca.pem");
  EXPECT_THAT(settings->headers, ElementsAre(Pair("authorization", "Bearer secret"), Pair("x-tenant", "a=b")));
  setenv("OTEL_SERVICE_NAME", "two", 1);
  EXPECT_EQ(text_of(*otlp_settings("http://a"), "service.name"), "two");
}

TEST_F(OtlpSettingsTest, TellsOfWrongVariablesWithoutTheirSecrets) {
  for (const char* bad : {"secret", "a=b,secret", "=secret", "a=%zzsecret", "a=secret%2", "a=secret%0d%0aHost: x",
                          "a b=secret", "a:=secret"}) {
    setenv("OTEL_EXPORTER_OTLP_HEADERS", bad, 1);
    const absl::Status status = otlp_settings("http://a").status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << bad;
    EXPECT_THAT(std::string(status.message()), HasSubstr("OTEL_EXPORTER_OTLP_HEADERS"));
    EXPECT_THAT(std::string(status.message()), Not(HasSubstr("secret")));
  }
}

TEST_F(OtlpSettingsTest, ReadsPairs) {
  EXPECT_THAT(*parse_pairs(""), ElementsAre());
  EXPECT_THAT(*parse_pairs(" , a = b ,, c=%41%2c "), ElementsAre(Pair("a", "b"), Pair("c", "A,")));
  EXPECT_THAT(*parse_pairs("a="), ElementsAre(Pair("a", "")));
}

}  // namespace
}  // namespace segserve::server
