// SPDX-License-Identifier: Apache-2.0
#include "credentials/watched_file.hpp"

#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "gmock/gmock.h"

namespace segserve::credentials {
namespace {

class WatchedFileTest : public testing::Test {
 protected:
  WatchedFileTest() { std::filesystem::create_directories(folder_); }
  ~WatchedFileTest() override { std::filesystem::remove_all(folder_); }

  void write(const std::string& name, const std::string& content) const { std::ofstream(folder_ / name) << content; }

  const std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) / testing::UnitTest::GetInstance()->current_test_info()->name();
};

TEST_F(WatchedFileTest, TellsAChangeOnceAndAfterItHasSettled) {
  write("f", "one");
  WatchedFile file(folder_ / "f", 100);
  EXPECT_EQ(*file.read(), "one");
  EXPECT_EQ(file.changed(), std::nullopt);
  write("f", "two");
  EXPECT_EQ(file.changed(), std::nullopt) << "it may be half of what is written";
  write("f", "two and a half");
  EXPECT_EQ(file.changed(), std::nullopt);
  EXPECT_EQ(**file.changed(), "two and a half");
  EXPECT_EQ(file.changed(), std::nullopt);
}

TEST_F(WatchedFileTest, AChangeThatIsTakenBackIsNone) {
  write("f", "one");
  WatchedFile file(folder_ / "f", 100);
  EXPECT_EQ(*file.read(), "one");
  write("f", "");
  EXPECT_EQ(file.changed(), std::nullopt);
  write("f", "one");
  EXPECT_EQ(file.changed(), std::nullopt);
  EXPECT_EQ(file.changed(), std::nullopt);
}

TEST_F(WatchedFileTest, FollowsALinkThatTurns) {
  write("a", "one");
  write("b", "two");
  std::filesystem::create_symlink("a", folder_ / "link");
  WatchedFile file(folder_ / "link", 100);
  EXPECT_EQ(*file.read(), "one");
  std::filesystem::create_symlink("b", folder_ / "next");
  std::filesystem::rename(folder_ / "next", folder_ / "link");
  EXPECT_EQ(file.changed(), std::nullopt);
  EXPECT_EQ(**file.changed(), "two");
}

TEST_F(WatchedFileTest, TellsThatAFileIsGoneAndThatItIsBack) {
  write("f", "one");
  WatchedFile file(folder_ / "f", 100);
  EXPECT_EQ(*file.read(), "one");
  std::filesystem::remove(folder_ / "f");
  EXPECT_EQ(file.changed(), std::nullopt);
  const auto gone = file.changed();
  ASSERT_TRUE(gone.has_value());
  EXPECT_TRUE(absl::IsNotFound(gone->status()));
  EXPECT_THAT(std::string(gone->status().message()), testing::HasSubstr((folder_ / "f").string()));
  EXPECT_EQ(file.changed(), std::nullopt) << "it is told once";
  write("f", "one");
  EXPECT_EQ(file.changed(), std::nullopt);
  EXPECT_EQ(**file.changed(), "one");
}

TEST_F(WatchedFileTest, TellsThatAPipeHasTakenItsPlace) {
  write("f", "one");
  WatchedFile file(folder_ / "f", 100);
  EXPECT_EQ(*file.read(), "one");
  std::filesystem::remove(folder_ / "f");
  ASSERT_EQ(mkfifo((folder_ / "f").c_str(), 0600), 0);
  EXPECT_EQ(file.changed(), std::nullopt) << "and it waits for nobody who writes into it";
  EXPECT_TRUE(absl::IsNotFound(file.changed()->status()));
}

}  // namespace
}  // namespace segserve::credentials
