// SPDX-License-Identifier: Apache-2.0
#include <pthread.h>
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
#include "grpc/support/log.h"
#include "server/app/flags.hpp"
#include "server/listener/file_descriptors.hpp"
#include "server/listener/listener_watch.hpp"
#include "server/memory/memory_return.hpp"
#include "server/options/listen_address.hpp"
#include "server/server.hpp"
#include "server/version.hpp"
#include "spdlog/sinks/stdout_color_sinks.h"
#include "spdlog/spdlog.h"

namespace {

constexpr int kNotStoppedInTime = 3;
constexpr int kDeaf = 4;
// What stopping may take beyond the grace period.
constexpr std::chrono::milliseconds kStopTime{1800};

/// Blocks the signals that stop the server, for this thread and every thread that it starts from now on.
sigset_t block_stop_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

/// Sends gRPC's own lines to our log as debug lines, because gRPC calls everything an error.
void log_grpc(gpr_log_func_args* line) { spdlog::debug("grpc: {}:{}: {}", line->file, line->line, line->message); }

void start_logging(spdlog::level::level_enum level) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("segserve"));
  spdlog::set_pattern("%Y-%m-%dT%H:%M:%S.%e%z %^%l%$ %v");
  spdlog::set_level(level);
  gpr_set_log_function(log_grpc);
}

/// Writes the file in one step, so that a program that waits for it never reads half of it.
bool write_port_file(const std::string& path, int port) {
  const std::string temporary = path + ".tmp";
  std::ofstream(temporary) << port << '\n';
  std::error_code error;
  std::filesystem::rename(temporary, path, error);
  return !error;
}

/// Ends the process if it has not stopped in time, for example because a call hangs within gRPC.
void end_process_after(std::chrono::milliseconds time, int exit_code) {
  std::thread([time, exit_code] {
    std::this_thread::sleep_for(time);
    spdlog::critical("not stopped within {} ms: ending the process", time.count());
    std::_Exit(exit_code);
  }).detach();
}

/// Null if the flags do not want a watch.
std::unique_ptr<segserve::server::ListenerWatch> watch_listener(const segserve::server::Flags& flags, int port,
                                                                std::function<void()> on_deaf) {
  auto address = segserve::server::parse_listen_address(flags.server.listen);
  if (flags.listener_check == std::chrono::milliseconds(0) || !address.ok()) return nullptr;
  return std::make_unique<segserve::server::ListenerWatch>(*std::move(address), port, flags.listener_check,
                                                           std::move(on_deaf));
}

int serve(const segserve::server::Flags& flags, const sigset_t& stop_signals) {
  absl::StatusOr<std::unique_ptr<segserve::server::Server>> server = segserve::server::Server::start(flags.server);
  if (!server.ok()) {
    fmt::print(stderr, "segserve: {}\n", std::string(server.status().message()));
    return 1;
  }
  if (!flags.port_file.empty() && !write_port_file(flags.port_file, (*server)->port())) {
    fmt::print(stderr, "segserve: cannot write the port to {}\n", flags.port_file);
    return 1;
  }
  spdlog::info("segserve {} serves on {}", segserve::server::kVersion, (*server)->address());

  std::atomic<bool> is_deaf{false};
  int signal = 0;
  {
    const auto watch = watch_listener(flags, (*server)->port(), [&is_deaf] {
      is_deaf = true;
      kill(getpid(), SIGTERM);
    });
    sigwait(&stop_signals, &signal);
    end_process_after(flags.server.grace_period + kStopTime, is_deaf ? kDeaf : kNotStoppedInTime);
  }
  if (is_deaf) spdlog::critical("the server accepts no connections any more; another process has to take over");
  spdlog::info("{}: stopping, {} calls in flight", sigabbrev_np(signal), (*server)->calls());
  (*server)->stop();
  spdlog::info("stopped");
  return is_deaf ? kDeaf : 0;
}

}  // namespace

int main(int argc, char** argv) {
  const sigset_t stop_signals = block_stop_signals();
  segserve::server::keep_freed_memory();
  segserve::server::raise_file_descriptor_limit();
  const auto flags = segserve::server::parse_flags(argc, argv);
  if (const int* exit_code = std::get_if<int>(&flags)) return *exit_code;
  start_logging(std::get<segserve::server::Flags>(flags).log_level);
  return serve(std::get<segserve::server::Flags>(flags), stop_signals);
}
