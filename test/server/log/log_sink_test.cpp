// SPDX-License-Identifier: Apache-2.0
#include "server/log/log_sink.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <future>
#include <memory>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/log/log_formatter.hpp"
#include "spdlog/async.h"
#include "spdlog/async_logger.h"

namespace segserve::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::HasSubstr;

/// A logger as ProgramLog makes it, with a pipe for its lines that nobody reads at first.
class LogSinkTest : public testing::Test {
 protected:
  static constexpr std::size_t kQueue = 16;
  static constexpr int kPipeBytes = 4096;

  LogSinkTest() {
    std::signal(SIGPIPE, SIG_IGN);
    EXPECT_EQ(pipe(pipe_.data()), 0);
    fcntl(pipe_[1], F_SETPIPE_SZ, kPipeBytes);
    sink_ = std::make_shared<LogSink>(pipe_[1], std::make_unique<LogFormatter>(LogFormat::kText),
                                      [pool = pool_.get()] { return pool->overrun_counter(); });
    logger_ =
        std::make_shared<spdlog::async_logger>("test", sink_, pool_, spdlog::async_overflow_policy::overrun_oldest);
  }
  ~LogSinkTest() override {
    close_end(0);
    // First, so that its thread is not the one that deletes the logger, which ThreadSanitizer cannot follow.
    pool_.reset();
    logger_.reset();
    close_end(1);
  }

  void close_end(std::size_t end) {
    if (pipe_[end] >= 0) close(pipe_[end]);
    pipe_[end] = -1;
  }

  bool flush(milliseconds time) {
    const std::uint64_t before = sink_->flushes();
    logger_->flush();
    return sink_->wait_for_flush(before, time);
  }

  /// Reads until `end` has come.
  std::string read_until(const std::string& end) const {
    std::string text;
    std::array<char, 4096> bytes{};
    while (text.find(end) == std::string::npos) {
      const ssize_t count = read(pipe_[0], bytes.data(), bytes.size());
      if (count <= 0) break;
      text.append(bytes.data(), static_cast<std::size_t>(count));
    }
    return text;
  }

  std::array<int, 2> pipe_{-1, -1};
  std::shared_ptr<spdlog::details::thread_pool> pool_ = std::make_shared<spdlog::details::thread_pool>(kQueue, 1);
  std::shared_ptr<LogSink> sink_;
  std::shared_ptr<spdlog::async_logger> logger_;
};

TEST_F(LogSinkTest, WritesLines) {
  logger_->info("hello");
  ASSERT_TRUE(flush(seconds(20)));
  EXPECT_THAT(read_until("\n"), HasSubstr(" info hello\n"));
}

TEST_F(LogSinkTest, MakesNobodyWaitForAReaderAndTellsHowManyLinesWereLost) {
  const std::string line(kPipeBytes, 'x');
  constexpr int kLines = 1000;
  for (int i = 0; i < kLines; ++i) logger_->info("{}", line);  // would never return if it waited
  EXPECT_FALSE(flush(milliseconds(10)));
  logger_->info("the end");
  const std::string text = read_until("the end\n");
  EXPECT_THAT(text, HasSubstr("lines of this log were lost, because it was not read fast enough lines="));
  EXPECT_THAT(text, HasSubstr(" info the end\n"));
}

TEST_F(LogSinkTest, WaitsForRoomInAPipeThatDoesNotBlock) {
  fcntl(pipe_[1], F_SETFL, O_NONBLOCK);
  const std::string noise(4096, 'x');
  // A write of a page is all or nothing, so that it may leave room for less.
  while (write(pipe_[1], noise.data(), noise.size()) > 0 || write(pipe_[1], noise.data(), 1) > 0) {
  }
  logger_->info("late");
  EXPECT_FALSE(flush(milliseconds(10)));
  EXPECT_THAT(read_until("late\n"), HasSubstr(" info late\n"));
}

TEST_F(LogSinkTest, GoesOnWithoutAReader) {
  close_end(0);
  logger_->info("into the void");
  EXPECT_TRUE(flush(seconds(20)));
}

}  // namespace
}  // namespace segserve::server
