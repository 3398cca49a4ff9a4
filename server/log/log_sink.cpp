// SPDX-License-Identifier: Apache-2.0
#include "server/log/log_sink.hpp"

#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <string>
#include <string_view>
#include <utility>

#include "server/log/log_event.hpp"
#include "server/log/log_payload.hpp"

namespace segserve::server {
namespace {

void write_all(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(file, bytes.data(), bytes.size());
    if (written >= 0) {
      bytes.remove_prefix(static_cast<std::size_t>(written));
    } else if (errno == EAGAIN) {
      pollfd writable{.fd = file, .events = POLLOUT, .revents = 0};
      poll(&writable, 1, -1);
    } else if (errno != EINTR) {
      return;  // nobody reads any more
    }
  }
}

std::string_view color_of(spdlog::level::level_enum level) {
  switch (level) {
    case spdlog::level::debug:
      return "\x1b[36m";
    case spdlog::level::info:
      return "\x1b[32m";
    case spdlog::level::warn:
      return "\x1b[33;1m";
    default:
      return "\x1b[31;1m";
  }
}

/// The line with its level in color.
std::string colored(std::string_view line, const spdlog::details::log_msg& message) {
  constexpr std::string_view kUsualColor = "\x1b[0m";
  std::string result(line.substr(0, message.color_range_start));
  result += color_of(message.level);
  result += line.substr(message.color_range_start, message.color_range_end - message.color_range_start);
  result += kUsualColor;
  result += line.substr(message.color_range_end);
  return result;
}

}  // namespace

LogSink::LogSink(int file, std::unique_ptr<spdlog::formatter> formatter, std::function<std::size_t()> lost_lines)
    : base_sink(std::move(formatter)),
      file_(file),
      is_terminal_(isatty(file) == 1),
      lost_lines_(std::move(lost_lines)) {}

std::uint64_t LogSink::flushes() const {
  const MutexLock lock(mutex_of_flushes_);
  return flushes_;
}

bool LogSink::wait_for_flush(std::uint64_t before, std::chrono::milliseconds time) {
  const auto deadline = std::chrono::steady_clock::now() + time;
  const MutexLock lock(mutex_of_flushes_);
  while (flushes_ <= before && flushed_.wait_until(mutex_of_flushes_, deadline)) {
  }
  return flushes_ > before;
}

void LogSink::sink_it_(const spdlog::details::log_msg& message) {
  tell_lost_lines();
  write_line(message);
}

void LogSink::flush_() {
  tell_lost_lines();
  const MutexLock lock(mutex_of_flushes_);
  ++flushes_;
  flushed_.notify_all();
}

void LogSink::tell_lost_lines() {
  const std::size_t lost = lost_lines_();
  if (lost == told_lost_lines_) return;
  const std::array fields{LogField("lines", lost - told_lost_lines_)};
  const std::string payload = pack_payload("lines of this log were lost, because it was not read fast enough", fields);
  told_lost_lines_ = lost;
  write_line(spdlog::details::log_msg(fields_mark(), "", spdlog::level::warn, payload));
}

void LogSink::write_line(const spdlog::details::log_msg& message) {
  spdlog::memory_buf_t buffer;
  formatter_->format(message, buffer);
  const std::string_view line(buffer.data(), buffer.size());
  const bool has_color = is_terminal_ && message.color_range_end > message.color_range_start;
  if (has_color) {
    write_all(file_, colored(line, message));
  } else {
    write_all(file_, line);
  }
}

}  // namespace segserve::server
