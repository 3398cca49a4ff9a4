// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <memory>

#include "server/log/log_formatter.hpp"
#include "spdlog/common.h"

namespace segserve::server {

class LogSink;

/// The log of the program, on standard error. From its construction to `finish`, spdlog's default logger hands lines to
/// a thread of its own by a bounded queue, from which the oldest are lost if nobody reads them fast enough. So no other
/// thread ever waits for a terminal or a pipe. There is one object in a process.
class ProgramLog {
 public:
  ProgramLog(LogFormat format, spdlog::level::level_enum level);

  /// One step toward debug, or toward off. Says so in a line that one of the two levels shows.
  void change_level(bool more_talkative);

  /// Waits until all lines are written; false if they are not within `time`.
  bool flush(std::chrono::milliseconds time);

  /// Writes what is left, and ends the logging. If nobody reads it within a second, this ends the process instead, with
  /// this exit code: its threads could not be joined.
  void finish(int exit_code);

 private:
  std::shared_ptr<LogSink> sink_;
};

}  // namespace segserve::server
