// SPDX-License-Identifier: Apache-2.0
#include "server/app/announcement.hpp"

#include <unistd.h>

#include <chrono>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "fmt/format.h"
#include "server/log/log_event.hpp"
#include "server/version.hpp"
#include "tls/certificates.hpp"

namespace segserve::server {
namespace {

double seconds(std::chrono::milliseconds time) { return std::chrono::duration<double>(time).count(); }

}  // namespace

void announce(const Server& server, const Flags& flags) {
  const ServerOptions& options = server.options();
  const std::string health_port = server.health_port() == 0 ? "" : fmt::format("{}", server.health_port());
  const std::optional<TlsStatus> tls = server.tls_status();
  const std::string certificate_end = tls ? tls::text_of(tls->certificate_end) : "";
  const bool asks_for_tokens = !options.tokens.empty() || !options.jwt_keys.empty();
  const std::vector<LogField> identity = {{"version", kVersion},
                                          {"address", server.address()},
                                          {"tls", !tls                 ? "off"
                                                  : tls->client_ca_end ? "mutual"
                                                                       : "on"},
                                          {"certificate_end", certificate_end},
                                          {"tokens", asks_for_tokens ? "required" : "off"},
                                          {"health_listen", options.health_listen},
                                          {"health_port", health_port},
                                          {"http", options.http},
                                          {"otlp_endpoint", flags.otlp_endpoint},
                                          {"reflection", options.reflection ? "on" : "off"},
                                          {"pid", std::int64_t{getpid()}}};
  log_event(spdlog::level::info, "segserve serves", identity);
  const std::vector<LogField> limits = {{"workers", options.workers},
                                        {"threads", options.threads},
                                        {"queue", options.queue},
                                        {"queue_bytes", options.queue_bytes},
                                        {"queue_points", options.queue_points},
                                        {"stream_frames", options.stream_frames},
                                        {"stream_bytes", options.stream_bytes},
                                        {"max_points", options.max_points},
                                        {"max_decoded_bytes", options.max_decoded_bytes},
                                        {"max_voxels", options.max_voxels},
                                        {"memory_bytes", options.memory},
                                        {"max_frame_s", seconds(options.max_frame_time)},
                                        {"grace_period_s", seconds(options.grace_period)},
                                        {"max_stream_age_s", seconds(options.max_stream_age)},
                                        {"ping_interval_s", seconds(options.ping_interval)},
                                        {"listener_check_s", seconds(flags.listener_check)}};
  log_event(spdlog::level::info, "limits", limits);
}

void announce_stop(const Server& server, int signal) {
  const std::vector<LogField> fields = {{"signal", sigabbrev_np(signal)},
                                        {"calls", server.calls()},
                                        {"grace_period_s", seconds(server.options().grace_period)}};
  log_event(spdlog::level::info, "stopping", fields);
}

}  // namespace segserve::server
