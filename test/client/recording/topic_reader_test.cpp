// SPDX-License-Identifier: Apache-2.0
#include "segserve/client/topic_reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <string>

#include "client/recording/topic/topic_view.hpp"
#include "test/client/recording/recording_files.hpp"

namespace segserve::client {
namespace {

using recording::Channel;
using recording::cloud_message;
using recording::McapWriter;
using recording::Message;
using recording::TemporaryFile;
using testing::HasSubstr;

/// Three clouds on /points, the second of them broken, another topic of clouds if asked for, and a topic of text.
std::string recording_of_clouds(bool second_topic = false) {
  return recording::mcap_with([&](McapWriter& writer) {
    EXPECT_TRUE(writer.define(1, recording::cloud_schema()).ok());
    EXPECT_TRUE(writer.define(1, Channel{1, "/points", "cdr", {}}).ok());
    EXPECT_TRUE(writer.define(2, Channel{0, "/text", "json", {}}).ok());
    if (second_topic) {
      EXPECT_TRUE(writer.define(3, Channel{1, "/more", "cdr", {}}).ok());
    }
    for (std::uint32_t i = 0; i < 3; ++i) {
      const auto z = static_cast<float>(i);
      std::string data = cloud_message({{1, 2, z}, {3, 4, 5}}, "lidar_top", 1000 + i);
      if (i == 1) data.resize(50);
      EXPECT_TRUE(writer.write(Message{1, i, 2000 + i, 0, data}).ok());
      EXPECT_TRUE(writer.write(Message{2, i, 2000 + i, 0, "{}"}).ok());
    }
  });
}

TEST(TopicReader, ReadsTheFramesOfATopic) {
  const TemporaryFile file(recording_of_clouds());
  auto reader = TopicReader::open(file.path());
  ASSERT_TRUE(reader.ok()) << reader.status();
  EXPECT_EQ(reader->topic().name, "/points");
  EXPECT_EQ(reader->topic().messages, 3U);
  for (std::uint64_t i = 0; i < 3; ++i) {
    const auto frame = reader->next();
    ASSERT_TRUE(frame.ok() && *frame) << i;
    EXPECT_EQ((*frame)->index, i);
    EXPECT_EQ((*frame)->log_time.time_since_epoch(), std::chrono::nanoseconds(2000 + i));
    EXPECT_EQ((*frame)->content.ok(), i != 1) << "a broken message does not concern the others";
    if (i == 1) continue;
    EXPECT_EQ((*frame)->stamp.time_since_epoch(), std::chrono::nanoseconds(1000 + i));
    EXPECT_EQ((*frame)->frame_id, "lidar_top");
    EXPECT_EQ((*frame)->content->cloud.z[0], static_cast<float>(i));
    EXPECT_EQ((*frame)->content->cloud.view, View::world(0, 0, 0));
  }
  EXPECT_FALSE(*reader->next());
  EXPECT_TRUE(reader->warnings().empty());
}

TEST(TopicReader, AGivenViewReplacesTheRule) {
  const TemporaryFile file(recording_of_clouds());
  auto reader = TopicReader::open(file.path(), {.view = View::world(1, 2, 3)});
  EXPECT_EQ((*reader->next())->content->cloud.view, View::world(1, 2, 3));
}

TEST(TopicReader, AWrongTopicListsTheTopics) {
  const TemporaryFile file(recording_of_clouds(true));
  const auto message = [&](const std::string& topic) {
    return std::string(TopicReader::open(file.path(), {.topic = topic}).status().message());
  };
  EXPECT_THAT(message("/nothing"), HasSubstr("there is no topic /nothing; its topics are /more ("));
  EXPECT_THAT(message("/nothing"), HasSubstr("/points (sensor_msgs/msg/PointCloud2, cdr, 3 messages)"));
  EXPECT_THAT(message("/text"), HasSubstr("it is no topic that can be read"));
  EXPECT_THAT(message(""), HasSubstr("several topics can be read"));
  EXPECT_THAT(message(""), HasSubstr(file.path())) << "the file is named";
}

TEST(TopicReader, CloudsThatCannotBeReadComeWithAdvice) {
  struct Case {
    const char *type, *encoding, *advice;
  };
  for (const Case& c : std::vector<Case>{
           {"foxglove.PointCloud", "json", "/points: messages in JSON are not read"},
           {"foxglove.CompressedPointCloud", "protobuf", "/points: compressed clouds are not read"},
           {"point_cloud_interfaces/msg/CompressedPointCloud2", "cdr", "/points: compressed clouds are not read"},
           {"livox_ros_driver2/msg/CustomMsg", "cdr", "xfer_format 0"},
           {"velodyne_msgs/msg/VelodyneScan", "cdr", "the LiDAR's driver makes PointCloud2"},
           {"sensor_msgs/msg/PointCloud", "cdr", "PointCloud is older than PointCloud2"},
           {"sensor_msgs/msg/LaserScan", "cdr", "a scan within a plane is no cloud"}}) {
    const TemporaryFile file(recording::mcap_with([&](McapWriter& writer) {
      EXPECT_TRUE(writer.define(1, recording::Schema{c.type, "ros2msg", "# abridged"}).ok());
      EXPECT_TRUE(writer.define(1, Channel{1, "/points", c.encoding, {}}).ok());
      EXPECT_TRUE(writer.write(Message{1, 0, 2000, 0, "data"}).ok());
    }));
    for (const char* topic : {"", "/points"}) {
      const auto opened = TopicReader::open(file.path(), {.topic = topic});
      EXPECT_THAT(std::string(opened.status().message()), HasSubstr(c.advice)) << topic;
    }
  }
}

TEST(TopicReader, ListsTopicsWithAndWithoutAnIndex) {
  std::string bytes = recording_of_clouds();
  for (const bool cut : {false, true}) {
    if (cut) bytes.resize(bytes.size() - 20);
    const TemporaryFile file(bytes);
    const auto topics = list_topics(file.path());
    ASSERT_TRUE(topics.ok()) << topics.status();
    ASSERT_EQ(topics->size(), 2U);
    EXPECT_EQ(topics->at(0).name, "/points");
    EXPECT_EQ(topics->at(0).messages, 3U);
    EXPECT_TRUE(topics->at(0).has_frames);
    EXPECT_FALSE(topics->at(1).has_frames);
  }
}

TEST(TopicReader, KnowsARecordingByItsBeginning) {
  EXPECT_TRUE(is_recording(recording_of_clouds().substr(0, 16)));
  EXPECT_FALSE(is_recording("# .PCD v0.7"));
}

struct ViewCase {
  const char* frame_id;
  std::uint32_t height;
  float least_z;
  View expected;
};

TEST(TopicReader, TheViewFollowsTheRule) {
  for (const ViewCase& given :
       {ViewCase{"camera_color_optical_frame", 2, 1, View::camera()},
        ViewCase{"camera_color_optical_frame", 1, 1, View::camera()},
        ViewCase{"camera_color_optical_frame", 2, -1, View::world(0, 0, 0)},
        ViewCase{"robot/kinect", 2, 1, View::camera()}, ViewCase{"base_link", 2, 1, View::world()},
        ViewCase{"robot/map", 2, 1, View::world()}, ViewCase{"unknown", 2, -1, View::world(0, 0, 0)},
        ViewCase{"unknown", 1, -1, View::world()}, ViewCase{"/Velodyne", 1, -1, View::world(0, 0, 0)},
        ViewCase{"", 1, 1, View::world()}}) {
    codec::LabeledCloud content;
    content.cloud.x = content.cloud.y = {0, 1, 2, 3};
    content.cloud.z = {0, 2, given.least_z, 4};
    content.cloud.width = 4 / given.height;
    content.cloud.height = given.height;
    recording::choose_view(given.frame_id, false, content);
    EXPECT_EQ(content.cloud.view, given.expected) << given.frame_id << ": " << content.view_rule;
  }
}

}  // namespace
}  // namespace segserve::client
