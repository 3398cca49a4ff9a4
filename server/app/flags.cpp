// SPDX-License-Identifier: Apache-2.0
#include "server/app/flags.hpp"

#include <chrono>
#include <map>

#include "CLI/CLI.hpp"
#include "command_line/not_negative.hpp"
#include "command_line/usage_faults.hpp"
#include "fmt/format.h"
#include "server/server.hpp"
#include "server/version.hpp"

namespace segserve::server {
namespace {

constexpr int kUsageError = 2;
constexpr std::chrono::milliseconds kLeastListenerCheck{500};

constexpr const char* kExamples = R"(Examples:
  segserve                                      serve on 127.0.0.1:50051, one worker per CPU
  segserve --listen 127.0.0.1:0 --port-file p   pick a free port and write it to the file p
  segserve --listen unix:/run/segserve.sock     serve this machine only, on a unix socket
  segserve --workers 4 --threads 2 --queue 16   4 frames at a time, up to 2 threads each, 16 may wait

SIGTERM and SIGINT stop the server: health turns NOT_SERVING, new calls are refused, calls in flight finish within
the grace period. Exit codes: 0 stopped by a signal, 1 cannot serve, 2 wrong flags,
3 a call kept the server from stopping in time, 4 it stopped because it accepted no connections any more.)";

const std::map<std::string, spdlog::level::level_enum> kLogLevels = {
    {"debug", spdlog::level::debug}, {"info", spdlog::level::info}, {"warn", spdlog::level::warn},
    {"error", spdlog::level::err},   {"off", spdlog::level::off},
};

/// Adds a flag that takes a duration in seconds, e.g. 0.5.
void add_seconds(CLI::App& app, const std::string& name, const std::string& help, std::chrono::milliseconds& value) {
  const auto set = [&value](const double& seconds) {
    value = std::chrono::milliseconds(static_cast<std::int64_t>(seconds * 1000));
  };
  app.add_option_function<double>(name, set, help)
      ->check(CLI::Range(0.0, 86'400.0).description(""))
      ->type_name("SECONDS")
      ->default_str(fmt::format("{}", std::chrono::duration<double>(value).count()));
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
  app.add_option("--port-file", flags.port_file, "Write the port to this file once the server is ready")
      ->type_name("PATH");
  app.add_option("--workers", server.workers, "Frames that are computed at the same time; 0: one per CPU")
      ->check(not_negative())
      ->capture_default_str();
  app.add_option("--threads", server.threads, "Most threads within one frame")->capture_default_str();
  app.add_option("--queue", server.queue, "Frames that may wait for a worker; one more is refused")
      ->check(not_negative())
      ->capture_default_str();
  app.add_option("--queue-bytes", server.queue_bytes, "Most bytes of all requests that wait or are computed")
      ->check(not_negative())
      ->capture_default_str();
  app.add_option("--queue-points", server.queue_points, "Most points of all clouds that wait or are computed")
      ->check(not_negative())
      ->capture_default_str();
  app.add_option("--stream-frames", server.stream_frames, "Most frames that one stream may have under way")
      ->check(not_negative())
      ->capture_default_str();
  app.add_option("--stream-bytes", server.stream_bytes, "Most bytes of payload that one stream may have under way")
      ->check(not_negative())
      ->capture_default_str();
  app.add_option("--max-points", server.max_points, "Most points of one cloud")->capture_default_str();
  app.add_option("--max-decoded-bytes", server.max_decoded_bytes, "Most bytes of one cloud after decompression")
      ->check(not_negative())
      ->capture_default_str();
  app.add_option("--max-voxels", server.max_voxels, "Most voxels of one cloud")->capture_default_str();
  app.add_option("--memory", server.memory,
                 "Most memory for all frames, e.g. 4GiB; 0: 75 % of what the cgroup or the machine has")
      ->transform(CLI::AsSizeValue(false))
      ->type_name("BYTES")
      ->check(not_negative())
      ->capture_default_str();
  add_seconds(app, "--max-frame-seconds", "Most seconds for the computation of one frame", server.max_frame_time);
  app.add_flag("--enable-draco", server.enable_draco,
               "Accept Draco payloads; its library has known faults with hostile bytes");
  app.add_flag("--reflection", server.reflection,
               "Serve reflection, for tools such as grpcurl; for trusted networks only, as it has no bounds");
  add_seconds(app, "--grace-period", "Seconds that calls in flight have when the server stops", server.grace_period);
  add_seconds(app, "--drain-delay", "Seconds for which a stopping server still refuses calls before it closes",
              server.drain_delay);
  add_seconds(app, "--listener-check",
              "Seconds between connections of the server to itself; after three without an answer it stops; 0: never",
              flags.listener_check);
  app.add_option("--log-level", flags.log_level, "debug (one line a call), info, warn, error or off")
      ->transform(CLI::CheckedTransformer(kLogLevels, CLI::ignore_case).description(""))
      ->type_name("LEVEL")
      ->default_str("info");

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help or --version
    fmt::print(stderr, "segserve: {}\n", usage_faults(app, error));
    return kUsageError;
  }

  const std::vector<FieldViolation> faults = violations(server);
  for (const FieldViolation& fault : faults) {
    fmt::print(stderr, "segserve: --{}: {}\n", fault.field, fault.description);
  }
  const bool is_hasty = flags.listener_check.count() != 0 && flags.listener_check < kLeastListenerCheck;
  if (is_hasty) fmt::print(stderr, "segserve: --listener-check: it must be 0, or at least 0.5 s\n");
  if (!faults.empty() || is_hasty) return kUsageError;
  return flags;
}

}  // namespace segserve::server
