// SPDX-License-Identifier: Apache-2.0
#include "server/metrics/metrics_server.hpp"

#include <ctime>
#include <string>

#include "gtest/gtest.h"
#include "server/metrics/process_metrics.hpp"
#include "server/metrics/state_metrics.hpp"
#include "server/metrics/tls_metrics.hpp"

namespace segserve::server {
namespace {

TEST(MetricsServer, SaysWhyItCannotServe) {
  const auto first = MetricsServer::start(*parse_listen_address("127.0.0.1:0"), nullptr);
  ASSERT_TRUE(first.ok()) << first.status();
  const std::string taken = with_port(*parse_listen_address("127.0.0.1:0"), (*first)->port());
  const auto second = MetricsServer::start(*parse_listen_address(taken), nullptr);
  EXPECT_EQ(second.status().code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(second.status().message(), "cannot serve metrics on " + taken + ": Address already in use");
  EXPECT_EQ(MetricsServer::start(*parse_listen_address("unix:/tmp/metrics"), nullptr).status().code(),
            absl::StatusCode::kInvalidArgument);
}

/// The value of a metric without labels; -1 if it is absent.
double value_of(const prometheus::Collectable& source, const std::string& name) {
  for (const prometheus::MetricFamily& family : source.Collect()) {
    if (family.name == name) return family.metric.at(0).gauge.value + family.metric.at(0).counter.value;
  }
  return -1;
}

TEST(ProcessMetrics, AreThoseOfThisProcess) {
  const ProcessMetrics process;
  EXPECT_GE(value_of(process, "process_cpu_seconds_total"), 0);
  EXPECT_GT(value_of(process, "process_resident_memory_bytes"), 1e6);
  EXPECT_GT(value_of(process, "process_virtual_memory_bytes"), value_of(process, "process_resident_memory_bytes"));
  EXPECT_GE(value_of(process, "process_open_fds"), 3);
  EXPECT_GE(value_of(process, "process_max_fds"), value_of(process, "process_open_fds"));
  EXPECT_GE(value_of(process, "process_threads"), 1);
  const auto now = static_cast<double>(time(nullptr));
  EXPECT_LE(value_of(process, "process_start_time_seconds"), now + 2);
  EXPECT_GT(value_of(process, "process_start_time_seconds"), now - 3600);
}

TEST(StateMetrics, AreThoseOfTheService) {
  ServiceState state;
  state.pool = {.workers = 4,
                .busy_workers = 3,
                .waiting = 2,
                .longest_wait = std::chrono::milliseconds(1500),
                .held = {.jobs = 5, .bytes = 600, .points = 70},
                .bounds = {.jobs = 68, .bytes = 8000, .points = 900}};
  state.memory = {.budget = 1000, .leased = {1, 20, 300}, .refusals = 7, .is_short = true};
  state.streams = 8;
  state.unary_calls = 9;
  state.access_reloads = 11;
  const StateMetrics metrics([&state] { return state; });
  EXPECT_EQ(value_of(metrics, "segserve_workers"), 4);
  EXPECT_EQ(value_of(metrics, "segserve_workers_busy"), 3);
  EXPECT_EQ(value_of(metrics, "segserve_queue_frames"), 2);
  EXPECT_EQ(value_of(metrics, "segserve_queue_frames_limit"), 64);
  EXPECT_EQ(value_of(metrics, "segserve_queue_bytes"), 600);
  EXPECT_EQ(value_of(metrics, "segserve_queue_points_limit"), 900);
  EXPECT_EQ(value_of(metrics, "segserve_queue_longest_wait_seconds"), 1.5);
  EXPECT_EQ(value_of(metrics, "segserve_memory_leased_bytes"), 1) << "those that wait come first";
  EXPECT_EQ(value_of(metrics, "segserve_memory_limit_bytes"), 1000);
  EXPECT_EQ(value_of(metrics, "segserve_memory_short"), 1);
  EXPECT_EQ(value_of(metrics, "segserve_memory_refusals_total"), 7);
  EXPECT_EQ(value_of(metrics, "segserve_streams"), 8);
  EXPECT_EQ(value_of(metrics, "segserve_unary_calls"), 9);
  EXPECT_EQ(value_of(metrics, "segserve_draining"), 0);
  EXPECT_EQ(value_of(metrics, "segserve_access_reloads_total"), 11) << "those that were taken come first";
}

TEST(TlsMetrics, TellWhenCertificatesEndAndHowOftenTheyWereRenewed) {
  TlsStatus status;
  status.certificate_end = std::chrono::sys_seconds(std::chrono::seconds(1'900'000'000));
  status.reloads = 3;
  status.failed_reloads = 1;
  const TlsMetrics metrics([&status] { return status; });
  EXPECT_EQ(value_of(metrics, "segserve_tls_certificate_end_timestamp_seconds"), 1.9e9);
  EXPECT_EQ(metrics.Collect().at(0).metric.size(), 1U) << "there is no authority for clients";
  EXPECT_EQ(metrics.Collect().at(1).metric.at(0).counter.value, 3);
  EXPECT_EQ(metrics.Collect().at(1).metric.at(1).counter.value, 1);
  status.client_ca_end = std::chrono::sys_seconds(std::chrono::seconds(2'000'000'000));
  EXPECT_EQ(metrics.Collect().at(0).metric.at(1).gauge.value, 2e9);
}

}  // namespace
}  // namespace segserve::server
