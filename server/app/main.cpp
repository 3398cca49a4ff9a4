// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "fmt/format.h"
#include "server/app/announcement.hpp"
#include "server/app/flags.hpp"
#include "server/app/frame_reporter.hpp"
#include "server/app/signals.hpp"
#include "server/listener/file_descriptors.hpp"
#include "server/listener/listener_watch.hpp"
#include "server/log/program_log.hpp"
#include "server/memory/memory_return.hpp"
#include "server/server.hpp"
#include "spdlog/spdlog.h"

namespace {

constexpr int kNotStoppedInTime = 3;
constexpr int kDeaf = 4;
// The time that stopping may take beyond the grace period.
constexpr std::chrono::milliseconds kStopTime{1800};
// The last lines of the log may take so long when the process is ended.
constexpr std::chrono::milliseconds kLastLines{200};

/// Writes the file in one step, so that a program that waits for it never reads half of it. Does nothing without a
/// path.
bool write_port_file(const std::string& path, int port) {
  if (path.empty()) return true;
  const std::string temporary = path + ".tmp";
  std::ofstream(temporary) << port << '\n';
  std::error_code error;
  std::filesystem::rename(temporary, path, error);
  if (error) fmt::print(stderr, "segserve: cannot write the port to {}\n", path);
  return !error;
}

/// Ends the process if it has not stopped in time, for example because a call hangs within gRPC.
void end_process_after(std::chrono::milliseconds time, int exit_code, segserve::server::ProgramLog& log) {
  std::thread([time, exit_code, &log] {
    std::this_thread::sleep_for(time);
    spdlog::critical("not stopped within {} ms: ending the process", time.count());
    log.flush(kLastLines);
    std::_Exit(exit_code);
  }).detach();
}

/// Null if the flags do not want a watch.
std::unique_ptr<segserve::server::ListenerWatch> watch_listeners(const segserve::server::Flags& flags,
                                                                 const segserve::server::Server& server,
                                                                 std::function<void()> on_deaf) {
  if (flags.listener_check == std::chrono::milliseconds(0)) return nullptr;
  return std::make_unique<segserve::server::ListenerWatch>(server.listeners(), flags.listener_check,
                                                           std::move(on_deaf));
}

/// The time that the last traces may take after the last frame.
std::chrono::milliseconds time_for_traces(const segserve::server::Flags& flags) {
  return flags.otlp_endpoint.empty() ? std::chrono::milliseconds(0) : segserve::server::ExportPace().flush_time;
}

int serve(const segserve::server::Flags& flags, const sigset_t& signals, segserve::server::ProgramLog& log) {
  auto reporter = segserve::server::make_reporter(flags);
  if (!reporter.ok()) {
    fmt::print(stderr, "segserve: {}\n", std::string(reporter.status().message()));
    return 1;
  }
  absl::StatusOr<std::unique_ptr<segserve::server::Server>> server =
      segserve::server::Server::start(flags.server, segserve::server::core_backend_factory(),
                                      segserve::server::ServiceObservers({*std::move(reporter)}));
  if (!server.ok()) {
    fmt::print(stderr, "segserve: {}\n", std::string(server.status().message()));
    return 1;
  }
  if (!write_port_file(flags.health_port_file, (*server)->health_port())) return 1;
  if (!write_port_file(flags.metrics_port_file, (*server)->metrics_port())) return 1;
  if (!write_port_file(flags.http_port_file, (*server)->http_port())) return 1;
  if (!write_port_file(flags.port_file, (*server)->port())) return 1;
  segserve::server::announce(**server, flags);

  std::atomic<bool> is_deaf{false};
  int signal = 0;
  {
    const auto watch = watch_listeners(flags, **server, [&is_deaf, &server] {
      is_deaf = true;
      (*server)->set_alive(false);
      kill(getpid(), SIGTERM);
    });
    signal = segserve::server::wait_for_stop(signals, log);
    end_process_after(flags.server.grace_period + kStopTime + time_for_traces(flags),
                      is_deaf ? kDeaf : kNotStoppedInTime, log);
  }
  if (is_deaf) spdlog::critical("the server accepts no connections any more; another process has to take over");
  segserve::server::announce_stop(**server, signal);
  (*server)->stop();
  server->reset();  // sends the last traces, and tells what was refused
  spdlog::info("stopped");
  return is_deaf ? kDeaf : 0;
}

}  // namespace

int main(int argc, char** argv) {
  segserve::server::keep_freed_memory();
  segserve::server::raise_file_descriptor_limit();
  const auto parsed = segserve::server::parse_flags(argc, argv);
  if (const int* exit_code = std::get_if<int>(&parsed)) return *exit_code;
  const auto& flags = std::get<segserve::server::Flags>(parsed);
  if (flags.check_only) {
    fmt::print("OK\n");
    return 0;
  }
  // Only now, so that SIGTERM ends a program whose settings take long to read.
  const sigset_t signals = segserve::server::block_signals();
  segserve::server::ProgramLog log(flags.log_format, flags.log_level);
  const int exit_code = serve(flags, signals, log);
  log.finish(exit_code);
  return exit_code;
}
