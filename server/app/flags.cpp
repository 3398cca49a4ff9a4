// SPDX-License-Identifier: Apache-2.0
#include "server/app/flags.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <map>

#include "CLI/CLI.hpp"
#include "command_line/not_negative.hpp"
#include "command_line/number_range.hpp"
#include "command_line/usage_faults.hpp"
#include "core/base/status_text.hpp"
#include "fmt/format.h"
#include "server/config/configuration.hpp"
#include "server/server.hpp"
#include "server/traces/otlp_settings.hpp"
#include "server/version.hpp"
#include "tls/tls_reload.hpp"

namespace segserve::server {
namespace {

constexpr int kUsageError = 2;
constexpr std::chrono::milliseconds kLeastListenerCheck{500};

constexpr const char* kExamples = R"(Examples:
  segserve                                      serve on 127.0.0.1:50051, one worker per CPU
  segserve --listen 127.0.0.1:0 --port-file p   pick a free port and write it to the file p
  segserve --listen unix:/run/segserve.sock     serve this machine only, on a unix socket
  segserve --listen 0.0.0.0:50051 --tls-cert server.crt --tls-key server.key
                                                serve other machines, by TLS
  segserve --http 127.0.0.1:8080                serve browsers and curl, too: http://127.0.0.1:8080/
  segserve --workers 4 --threads 2 --queue 16   4 frames at a time, up to 2 threads each, 16 may wait
  segserve --config f.toml --check-config       tell all that is wrong with the file f.toml, and stop

Each flag can also be set by a variable, as in SEGSERVE_QUEUE_BYTES=2147483648, and by a key of the file that --config
names, as in queue-bytes = 2147483648. A flag goes before a variable, and a variable before the file.

SIGUSR1 makes the log one step more talkative, and SIGUSR2 one step less.
SIGTERM, SIGINT and SIGQUIT stop the server: health turns NOT_SERVING, new calls are refused, calls in flight finish within
the grace period. Exit codes: 0 stopped by a signal, 1 cannot serve, 2 wrong flags,
3 a call kept the server from stopping in time, 4 it stopped because it accepted no connections any more.)";

const std::map<std::string, spdlog::level::level_enum> kLogLevels = {
    {"debug", spdlog::level::debug},  {"info", spdlog::level::info}, {"warn", spdlog::level::warn},
    {"warning", spdlog::level::warn}, {"error", spdlog::level::err}, {"off", spdlog::level::off},
};

const std::map<std::string, LogFormat> kLogFormats = {{"text", LogFormat::kText}, {"json", LogFormat::kJson}};

/// Adds a flag that takes a duration in seconds, e.g. 0.5.
void add_seconds(CLI::App& app, const std::string& name, const std::string& help, std::chrono::milliseconds& value) {
  const auto set = [&value](const double& seconds) {
    value = std::chrono::milliseconds(static_cast<std::int64_t>(std::ceil(seconds * 1000)));
  };
  app.add_option_function<double>(name, set, help)
      ->check(seconds_range(0, 86'400))
      ->type_name("SECONDS")
      ->default_str(fmt::format("{}", std::chrono::duration<double>(value).count()));
}

/// Adds a flag that takes a number of bytes, e.g. 4GiB.
void add_bytes(CLI::App& app, const std::string& name, const std::string& help, std::uint64_t& value) {
  app.add_option(name, value, help)
      ->transform(CLI::AsSizeValue(false).description(""))
      ->type_name("BYTES")
      ->check(not_negative())
      ->capture_default_str();
}

/// Whether one of the faults is that of an option.
bool is_faulty(const std::string& option, const Configuration& configuration, const std::vector<std::string>& faults) {
  const std::string place = configuration.place_of(option) + ": ";
  return std::ranges::any_of(faults,
                             [&place](const std::string& fault) { return fault.find(place) != std::string::npos; });
}

/// Adds what is wrong with values that are numbers and words as they should be.
void add_violations(const Flags& flags, const Configuration& configuration, std::vector<std::string>& faults) {
  std::vector<FieldViolation> found = violations(flags.server);
  const bool is_hasty = flags.listener_check.count() != 0 && flags.listener_check < kLeastListenerCheck;
  if (is_hasty) found.push_back({"listener-check", "it must be 0, or at least 0.5 s"});
  if (!flags.otlp_endpoint.empty()) {
    const absl::Status status = otlp_settings(flags.otlp_endpoint).status();
    if (!status.ok()) found.push_back({"otlp-endpoint", message_of(status)});
  }
  const std::vector<std::string> before = faults;
  for (const FieldViolation& fault : found) {
    if (is_faulty(fault.field, configuration, before)) continue;
    faults.push_back(fmt::format("{}: {}", configuration.place_of(fault.field), fault.description));
  }
}

/// Adds what is wrong with the content of the files of TLS.
void add_tls_fault(const ServerOptions& server, const Configuration& configuration, std::vector<std::string>& faults) {
  for (const char* option : {"tls-cert", "tls-key", "tls-client-ca"}) {
    if (is_faulty(option, configuration, faults)) return;
  }
  if (server.tls_cert.empty()) return;
  const auto loaded = tls::TlsReload::load({server.tls_cert, server.tls_key, server.tls_client_ca});
  if (loaded.ok()) return;
  faults.push_back(configuration.place_of("tls-cert") + ": " + message_of(loaded.status()));
}

}  // namespace

std::variant<Flags, int> parse_flags(int argc, const char* const* argv) {
  Flags flags;
  ServerOptions& server = flags.server;

  CLI::App app("Segments colored 3D point clouds, over gRPC.", "segserve");
  app.footer(kExamples);
  app.get_formatter()->column_width(36);
  app.set_version_flag("--version", fmt::format("segserve {}", kVersion));
  app.add_option("--listen", server.listen, "Address: HOST:PORT, [IPv6]:PORT or unix:PATH; port 0 picks a free one")
      ->type_name("ADDRESS")
      ->check(not_negative())
      ->capture_default_str();
  app.add_flag("--insecure-beyond-loopback", server.insecure_beyond_loopback,
               "Serve plain text on an address that other machines can reach");
  app.add_option("--health-listen", server.health_listen,
                 "Answer probes for health, and nothing else, at this address, in plain text")
      ->type_name("ADDRESS");
  app.add_option("--health-port-file", flags.health_port_file, "Write the port of --health-listen to this file")
      ->type_name("PATH");
  app.add_option("--tls-cert", server.tls_cert, "Speak TLS with the certificate, and its chain, of this file in PEM")
      ->type_name("FILE");
  app.add_option("--tls-key", server.tls_key, "The private key of the certificate")->type_name("FILE");
  app.add_option("--tls-client-ca", server.tls_client_ca,
                 "Serve only clients whose certificate is signed by an authority of this file")
      ->type_name("FILE");
  app.add_option("--tokens", server.tokens,
                 "Ask for bearer tokens: a file of their hashes and of the limits of their subjects, from segctl token")
      ->type_name("FILE");
  app.add_option("--jwt-keys", server.jwt_keys,
                 "Accept JSON Web Tokens that a key of this JSON Web Key Set has signed by RS256, ES256 or EdDSA")
      ->type_name("FILE");
  app.add_option("--jwt-issuer", server.jwt_issuer, "The issuer (iss) of JSON Web Tokens")->type_name("TEXT");
  app.add_option("--jwt-audience", server.jwt_audience, "The audience (aud) that JSON Web Tokens must name")
      ->type_name("TEXT");
  app.add_flag("--insecure-tokens", server.insecure_tokens,
               "Ask for tokens even in plain text on an address that other machines can reach");
  app.add_option("--metrics-listen", server.metrics_listen,
                 "Serve metrics for Prometheus at http://HOST:PORT/metrics, in plain text; port 0 picks a free one")
      ->type_name("ADDRESS");
  app.add_option("--metrics-port-file", flags.metrics_port_file, "Write the port of --metrics-listen to this file")
      ->type_name("PATH");
  app.add_option(
         "--http", server.http,
         "Open the web entrance at this address: a page, plain HTTP and the protocol Connect, by TLS if there is "
         "--tls-cert")
      ->type_name("ADDRESS");
  app.add_option("--http-allow-origin", server.http_allow_origin,
                 "Pages of this origin, e.g. https://app.example, may call the web entrance; *: those of all sites")
      ->type_name("ORIGIN");
  app.add_option(
         "--http-host", server.http_host,
         "Names of hosts, separated by commas, to which the web entrance answers besides localhost; on loopback "
         "it answers to no others, elsewhere to any by default")
      ->type_name("NAMES");
  app.add_option("--http-port-file", flags.http_port_file, "Write the port of --http to this file")->type_name("PATH");
  app.add_option("--port-file", flags.port_file, "Write the port to this file once the server is ready")
      ->type_name("PATH");
  app.add_option("--workers", server.workers, "Frames that are computed at the same time; 0: one per CPU")
      ->check(not_negative())
      ->capture_default_str();
  app.add_option("--threads", server.threads, "Most threads within one frame")
      ->check(not_negative())
      ->capture_default_str();
  app.add_option("--queue", server.queue, "Frames that may wait for a worker; one more is refused")
      ->check(not_negative())
      ->capture_default_str();
  add_bytes(app, "--queue-bytes", "Most bytes of all requests that wait or are computed", server.queue_bytes);
  app.add_option("--queue-points", server.queue_points, "Most points of all clouds that wait or are computed")
      ->check(not_negative())
      ->capture_default_str();
  app.add_option("--stream-frames", server.stream_frames, "Most frames that one stream may have under way")
      ->check(not_negative())
      ->capture_default_str();
  add_bytes(app, "--stream-bytes", "Most bytes of payload that one stream may have under way", server.stream_bytes);
  app.add_option("--max-points", server.max_points, "Most points of one cloud")
      ->check(not_negative())
      ->capture_default_str();
  add_bytes(app, "--max-decoded-bytes", "Most bytes of one cloud after decompression", server.max_decoded_bytes);
  app.add_option("--max-voxels", server.max_voxels, "Most voxels of one cloud")
      ->check(not_negative())
      ->capture_default_str();
  add_bytes(app, "--memory", "Most memory for all frames, e.g. 4GiB; 0: 75 % of what the cgroup or the machine has",
            server.memory);
  add_seconds(app, "--max-frame-seconds", "Most seconds for the computation of one frame", server.max_frame_time);
  app.add_flag("--enable-draco", server.enable_draco,
               "Accept Draco payloads; its library has known faults with hostile bytes");
  app.add_flag("--reflection", server.reflection, "Serve reflection, v1 and v1alpha, for tools such as grpcurl");
  add_seconds(app, "--grace-period", "Seconds that calls in flight have when the server stops", server.grace_period);
  add_seconds(app, "--drain-delay", "Seconds for which a stopping server still refuses calls before it closes",
              server.drain_delay);
  add_seconds(app, "--max-stream-age",
              "Seconds, give or take a tenth, after which a stream is asked to move to a new one; 0: never",
              server.max_stream_age);
  add_seconds(app, "--ping-interval",
              "Seconds between pings of connections with calls, for proxies that have no health checks; 0: never",
              server.ping_interval);
  add_seconds(app, "--listener-check",
              "Seconds between connections of the server to itself; after three without an answer it stops; 0: never",
              flags.listener_check);
  app.add_option("--log-level", flags.log_level, "debug (one line a frame), info, warn, error or off")
      ->transform(CLI::CheckedTransformer(kLogLevels, CLI::ignore_case).description(""))
      ->type_name("LEVEL")
      ->default_str("info");
  app.add_option("--log-format", flags.log_format, "text, or json: one object a line")
      ->transform(CLI::CheckedTransformer(kLogFormats, CLI::ignore_case).description(""))
      ->type_name("FORMAT")
      ->default_str("text");
  app.add_option("--otlp-endpoint", flags.otlp_endpoint,
                 "Send a trace of each frame to this collector of OpenTelemetry, e.g. http://127.0.0.1:4318")
      ->type_name("URL");
  app.add_option("--otlp-sample-ratio", flags.otlp_sample_ratio,
                 "Share of frames to record whose client sent no trace context")
      ->check(number_range(0, 1))
      ->type_name("SHARE")
      ->capture_default_str();

  Configuration configuration(app);
  bool print_config = false;
  app.add_flag("--check-config", flags.check_only, "Check all settings, also that files exist, and do not serve")
      ->configurable(false);
  app.add_flag("--print-config", print_config, "Write all settings as TOML to standard output, and do not serve")
      ->configurable(false);
  configuration.read(argc, argv, process_environment());

  std::vector<std::string> faults = configuration.faults();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help or --version
    faults.push_back(usage_faults(app, error));
  }
  for (const std::string& warning : configuration.warnings()) fmt::print(stderr, "segserve: warning: {}\n", warning);
  add_violations(flags, configuration, faults);
  if (flags.check_only) {
    std::ranges::move(configuration.missing_files(), std::back_inserter(faults));
    const bool all_there = faults.empty();
    add_tls_fault(server, configuration, faults);
    const absl::Status access = all_there ? Server::check_access_files(server) : absl::OkStatus();
    if (!access.ok()) faults.emplace_back(access.message());
  }
  for (const std::string& fault : faults) fmt::print(stderr, "segserve: {}\n", fault);
  if (!faults.empty()) return kUsageError;
  if (print_config) {
    fmt::print("{}", configuration.to_toml());
    return 0;
  }
  return flags;
}

}  // namespace segserve::server
