// SPDX-License-Identifier: Apache-2.0
#include "segserve/codec/cloud_file.hpp"

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "test/core/codec/support/sample_cloud.hpp"

namespace segserve::codec {
namespace {

class CloudFile : public testing::Test {
 protected:
  void SetUp() override {
    const testing::TestInfo* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = testing::TempDir() + "segserve_cloud_file_" + test->name();
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name) const { return folder_ + "/" + name; }
  std::string content(const std::string& name) const {
    std::ostringstream out;
    out << std::ifstream(path(name), std::ios::binary).rdbuf();
    return out.str();
  }

  std::string folder_;
};

TEST_F(CloudFile, ExtensionAndEncodingChooseTheFormat) {
  const Sample sample = make_sample(1, 20, 10, true, true);
  const std::vector<std::tuple<std::string, FileEncoding, std::string>> cases{
      {"a.pcd", FileEncoding::kBinary, "DATA binary_compressed\n"},
      {"b.PCD", FileEncoding::kText, "DATA ascii\n"},
      {"c.ply", FileEncoding::kBinary, "format binary_little_endian 1.0\n"},
      {"d.Ply", FileEncoding::kText, "format ascii 1.0\n"}};
  for (const auto& [name, encoding, line] : cases) {
    ASSERT_TRUE(save_cloud(path(name), sample.cloud, sample.label, encoding).ok()) << name;
    EXPECT_THAT(content(name), testing::HasSubstr(line));
    const auto read = load_cloud(path(name));
    ASSERT_TRUE(read.ok()) << read.status();
    expect_same_points(read->cloud, sample.cloud);
    EXPECT_EQ(read->label, sample.label);
  }
}

TEST_F(CloudFile, ContentNotTheNameTellsTheFormat) {
  const Sample sample = make_sample(1, 3, 1, true, false);
  ASSERT_TRUE(save_cloud(path("cloud.ply"), sample.cloud, {}).ok());
  std::filesystem::rename(path("cloud.ply"), path("cloud.pcd"));
  const auto read = load_cloud(path("cloud.pcd"), {.view = View::world(1, 2, 3)});
  ASSERT_TRUE(read.ok()) << read.status();
  expect_same_points(read->cloud, sample.cloud);
  EXPECT_EQ(read->cloud.view, View::world(1, 2, 3));
}

TEST_F(CloudFile, StandardInputIsRead) {
  const Sample sample = make_sample(1, 30, 20, true, true);
  ASSERT_TRUE(save_cloud(path("in.pcd"), sample.cloud, sample.label).ok());
  ASSERT_NE(std::freopen(path("in.pcd").c_str(), "rb", stdin), nullptr);
  const auto read = load_cloud("-");
  ASSERT_TRUE(read.ok()) << read.status();
  expect_same_points(read->cloud, sample.cloud);
}

TEST_F(CloudFile, FaultsNameTheFile) {
  const auto missing = load_cloud(path("missing.pcd")).status();
  EXPECT_EQ(missing.code(), absl::StatusCode::kNotFound) << missing;
  EXPECT_THAT(std::string(missing.message()), testing::StartsWith(path("missing.pcd") + ": cannot be opened"));

  std::ofstream(path("bad.pcd")) << "FIELDS x y\n";
  expect_fault(load_cloud(path("bad.pcd")).status(), path("bad.pcd") + ": PCD header: it ends without a line DATA");
  std::ofstream(path("empty.pcd")).flush();
  expect_fault(load_cloud(path("empty.pcd")).status(), path("empty.pcd") + ": the file is empty");
  expect_over_limit(load_cloud(path("bad.pcd"), {}, {.max_bytes = 5}).status(), "max_bytes",
                    "it has more bytes than the limit of 5");
  expect_fault(save_cloud(path("cloud.stl"), Cloud{}, {}),
               path("cloud.stl") + ": the name of a cloud must end in .pcd, .ply, .las, ");

  EXPECT_FALSE(load_cloud(folder_).ok());
  expect_fault(load_cloud("/dev/zero").status(), "/dev/zero: it is a character device");
  const auto nowhere = save_cloud(path("no/such/folder.pcd"), Cloud{}, {});
  EXPECT_EQ(nowhere.code(), absl::StatusCode::kNotFound) << nowhere;
}

TEST_F(CloudFile, NotesAreNoCloud) {
  std::ofstream(path("notes.txt")) << "what was scanned, and where";
  std::ofstream(path("points.TXT")) << "x y z\n1 2 3\n";
  std::ofstream(path("poses.txt")) << "time tx ty tz qx qy qz qw\n0 1 2 3 0 0 0 1\n";
  EXPECT_FALSE(is_cloud_file(path("notes.txt")));
  EXPECT_FALSE(is_cloud_file(path("poses.txt")));
  EXPECT_TRUE(is_cloud_file(path("points.TXT")));
  EXPECT_TRUE(is_cloud_file(path("a.las.gz")));
  EXPECT_FALSE(is_cloud_file(path("a.json")));
}

TEST_F(CloudFile, AFullDiskIsReported) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "/dev/full is not there";
  std::filesystem::create_symlink("/dev/full", path("full.pcd"));
  const auto status = save_cloud(path("full.pcd"), make_sample(1, 100, 100, true, false).cloud, {});
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable) << status;
  EXPECT_THAT(std::string(status.message()), testing::HasSubstr("writing failed: No space left"));
}

}  // namespace
}  // namespace segserve::codec
