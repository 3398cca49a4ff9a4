// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include "client/recording/mcap/mcap_writer.hpp"
#include "client/recording/message_source.hpp"
#include "client/recording/ros/point_cloud2.hpp"

// Recordings for tests.
namespace segserve::recording {

/// A file with the given content that is removed at the end.
class TemporaryFile {
 public:
  explicit TemporaryFile(std::string_view content) {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    static int count = 0;
    path_ = testing::TempDir() + "/" + test->test_suite_name() + "-" + test->name() + std::to_string(count++);
    std::ofstream(path_, std::ios::binary) << content;
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() { std::filesystem::remove(path_); }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// Everything that a recording holds.
struct Content {
  std::vector<Message> messages;  ///< without their data
  std::vector<std::string> data;
  std::vector<std::uint8_t> extras;  ///< opcodes
  Definitions definitions;
  std::vector<codec::Warning> warnings;
  absl::Status status;
};

inline Content read_all(std::string_view bytes, const codec::DecodeLimits& limits = {}) {
  const TemporaryFile file(bytes);
  Content content;
  const auto source = open_source(file.path(), limits);
  if (!source.ok()) {
    content.status = source.status();
    return content;
  }
  while (true) {
    const auto item = (*source)->next({});
    content.status = item.status();
    if (!item.ok() || !*item) break;
    if (const auto& message = (*item)->message) {
      content.messages.push_back(*message);
      content.data.emplace_back(message->data);
    } else {
      content.extras.push_back((*item)->extra.opcode);
    }
  }
  content.definitions = (*source)->definitions();
  content.warnings = (*source)->warnings();
  return content;
}

/// Writes what `fill` puts into a writer.
template <typename Fill>
std::string mcap_with(Fill fill) {
  std::string file;
  McapWriter writer(
      [&file](std::string_view bytes) {
        file += bytes;
        return absl::OkStatus();
      },
      "ros2");
  fill(writer);
  EXPECT_TRUE(writer.finish().ok());
  return file;
}

inline const Schema& cloud_schema() {
  static const Schema kSchema{"sensor_msgs/msg/PointCloud2", "ros2msg", "# abridged"};
  return kSchema;
}

/// A message PointCloud2 in CDR with the fields x, y, z of the given points.
inline std::string cloud_message(const std::vector<std::array<float, 3>>& points, const std::string& frame_id,
                                 std::int64_t stamp = 0, std::uint32_t height = 1) {
  PointCloud2 cloud;
  cloud.header = {0, stamp, frame_id};
  cloud.layout.width = static_cast<std::uint32_t>(points.size()) / height;
  cloud.layout.height = height;
  for (std::uint32_t i = 0; i < 3; ++i) {
    cloud.layout.fields.push_back({std::string(1, "xyz"[i]), 4 * i, codec::PointDatatype::kFloat32, 1});
  }
  cloud.layout.point_step = 12;
  cloud.layout.row_step = 12 * cloud.layout.width;
  cloud.data = {reinterpret_cast<const char*>(points.data()), points.size() * 12};
  return encode_point_cloud2(cloud, RosWire::kCdr);
}

}  // namespace segserve::recording
