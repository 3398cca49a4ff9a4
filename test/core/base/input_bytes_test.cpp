// SPDX-License-Identifier: Apache-2.0
#include "core/base/input_bytes.hpp"

#include <sys/stat.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "core/base/status_text.hpp"
#include "gmock/gmock.h"

namespace segserve {
namespace {

using namespace std::chrono_literals;

class InputBytes : public testing::Test {
 protected:
  InputBytes() {
    std::filesystem::create_directories(folder_);
    mkfifo(pipe_.c_str(), 0600);
  }
  ~InputBytes() override { std::filesystem::remove_all(folder_); }

  const std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) / testing::UnitTest::GetInstance()->current_test_info()->name();
  const std::string pipe_ = (folder_ / "pipe").string();
};

TEST_F(InputBytes, AFileHasABound) {
  const std::string path = folder_ / "f";
  const std::string content(3'000'000, 'x');
  std::ofstream(path) << content;
  EXPECT_EQ(*read_input_bytes(path, content.size()), content);
  EXPECT_EQ(read_input_bytes(path, 1000)->size(), 1001U) << "one more byte tells that there are too many";
}

TEST_F(InputBytes, APipeIsReadUntilItsWriterCloses) {
  std::thread writer([this] {
    std::this_thread::sleep_for(50ms);
    std::ofstream out(pipe_);
    for (int i = 0; i < 3; ++i) {
      out << std::string(100'000, 'x') << std::flush;
      std::this_thread::sleep_for(20ms);
    }
  });
  EXPECT_EQ(read_input_bytes(pipe_, 1'000'000)->size(), 300'000U);
  writer.join();
}

TEST_F(InputBytes, TheWaitForAWriterEndsWhenAskedTo) {
  const StopToken late(nullptr, StopToken::Clock::now() + 50ms);
  EXPECT_TRUE(absl::IsDeadlineExceeded(read_input_bytes(pipe_, 10, late).status()));
  std::atomic<bool> cancelled{false};
  std::thread canceller([&] {
    std::this_thread::sleep_for(50ms);
    cancelled = true;
  });
  EXPECT_TRUE(absl::IsCancelled(read_input_bytes(pipe_, 10, StopToken(&cancelled)).status()));
  canceller.join();
}

TEST_F(InputBytes, WhatIsNoFileIsRefusedByItsKind) {
  EXPECT_EQ(message_of(read_input_bytes("/dev/zero", 10).status()), "it is a character device, and no file");
  EXPECT_EQ(message_of(read_input_bytes(folder_, 10).status()), "it is a folder");
  EXPECT_TRUE(absl::IsInvalidArgument(read_input_bytes("/dev/zero", 10).status()));
  EXPECT_TRUE(absl::IsNotFound(read_input_bytes(folder_ / "none", 10).status()));
  EXPECT_TRUE(absl::IsUnavailable(read_input_bytes("/dev/fd/12345", 10).status()));
}

}  // namespace
}  // namespace segserve
