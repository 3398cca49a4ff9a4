// SPDX-License-Identifier: Apache-2.0
#include "core/base/regular_file.hpp"

#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "gmock/gmock.h"

namespace segserve {
namespace {

using testing::HasSubstr;

class RegularFile : public testing::Test {
 protected:
  RegularFile() { std::filesystem::create_directories(folder_); }
  ~RegularFile() override { std::filesystem::remove_all(folder_); }

  const std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) / testing::UnitTest::GetInstance()->current_test_info()->name();
};

TEST_F(RegularFile, IsReadUpToABound) {
  for (const std::size_t size : {std::size_t{0}, std::size_t{5}, std::size_t{16384}, std::size_t{100'000}}) {
    const std::string content(size, 'x');
    std::ofstream(folder_ / "f") << content;
    EXPECT_EQ(*read_regular_file(folder_ / "f", size), content);
    if (size == 0) continue;
    EXPECT_TRUE(absl::IsInvalidArgument(read_regular_file(folder_ / "f", size - 1).status())) << size;
  }
}

TEST_F(RegularFile, ALinkLeadsToIt) {
  std::ofstream(folder_ / "f") << "content";
  std::filesystem::create_symlink("f", folder_ / "link");
  EXPECT_EQ(*read_regular_file(folder_ / "link", 100), "content");
}

TEST_F(RegularFile, NothingElseIsReadOrWaitedFor) {
  const std::string pipe = folder_ / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  for (const std::string& path : {pipe, folder_.string(), std::string("/dev/zero")}) {
    const absl::Status status = read_regular_file(path, 100).status();
    EXPECT_TRUE(absl::IsNotFound(status)) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr(path + ": it is no regular file"));
  }
  EXPECT_THAT(std::string(read_regular_file("/no/such", 100).status().message()),
              HasSubstr("cannot read /no/such: No such file or directory"));
}

}  // namespace
}  // namespace segserve
