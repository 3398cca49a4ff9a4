// SPDX-License-Identifier: Apache-2.0
#include "server/log/program_log.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdlib>
#include <iterator>
#include <utility>

#include "grpc/support/log.h"
#include "server/log/log_sink.hpp"
#include "spdlog/async.h"
#include "spdlog/async_logger.h"
#include "spdlog/spdlog.h"

namespace segserve::server {
namespace {

constexpr std::size_t kQueuedLines = 8192;
constexpr std::array kLevels{spdlog::level::debug, spdlog::level::info, spdlog::level::warn, spdlog::level::err,
                             spdlog::level::off};

/// Sends gRPC's own lines to our log as debug lines, because gRPC calls everything an error.
void log_grpc(gpr_log_func_args* line) { spdlog::debug("grpc: {}:{}: {}", line->file, line->line, line->message); }

spdlog::level::level_enum neighbor_of(spdlog::level::level_enum level, bool more_talkative) {
  const auto found = std::ranges::find(kLevels, level);
  if (more_talkative) return found == kLevels.begin() ? level : *std::prev(found);
  return found == kLevels.end() || std::next(found) == kLevels.end() ? level : *std::next(found);
}

}  // namespace

ProgramLog::ProgramLog(LogFormat format, spdlog::level::level_enum level) {
  std::signal(SIGPIPE, SIG_IGN);  // the server goes on without a reader of its log
  spdlog::init_thread_pool(kQueuedLines, 1);
  const std::weak_ptr<spdlog::details::thread_pool> weak_pool = spdlog::thread_pool();
  sink_ = std::make_shared<LogSink>(STDERR_FILENO, std::make_unique<LogFormatter>(format), [weak_pool] {
    const auto pool = weak_pool.lock();
    return pool ? pool->overrun_counter() : 0;
  });
  auto logger = std::make_shared<spdlog::async_logger>("segserve", sink_, spdlog::thread_pool(),
                                                       spdlog::async_overflow_policy::overrun_oldest);
  logger->set_level(level);
  spdlog::set_default_logger(std::move(logger));
  gpr_set_log_function(log_grpc);
}

void ProgramLog::change_level(bool more_talkative) {
  const spdlog::level::level_enum before = spdlog::get_level(), after = neighbor_of(before, more_talkative);
  const spdlog::level::level_enum shown = std::max(spdlog::level::info, std::min(before, after));
  spdlog::set_level(std::min(before, after));
  spdlog::log(shown, "the level of this log is now {}", spdlog::level::to_string_view(after));
  spdlog::set_level(after);
}

bool ProgramLog::flush(std::chrono::milliseconds time) {
  const std::uint64_t before = sink_->flushes();
  spdlog::default_logger_raw()->flush();
  return sink_->wait_for_flush(before, time);
}

void ProgramLog::finish(int exit_code) {
  constexpr std::chrono::seconds kPatience{1};
  if (!flush(kPatience)) std::_Exit(exit_code);
  gpr_set_log_function(nullptr);
  spdlog::shutdown();
}

}  // namespace segserve::server
