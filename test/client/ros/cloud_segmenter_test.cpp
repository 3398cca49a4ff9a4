// SPDX-License-Identifier: Apache-2.0
// The core of the ROS nodes against a real server in this process.
#include "client/ros/core/cloud_segmenter.hpp"

#include <gmock/gmock.h>

#include <chrono>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "segserve/codec/strided.hpp"
#include "segserve/segment.hpp"
#include "server/server.hpp"
#include "test/server/support/server_scenes.hpp"

namespace segserve::ros {
namespace {

using namespace std::chrono_literals;  // NOLINT(google-build-using-namespace)
using testing::HasSubstr;

/// Collects the results and errors of a segmenter.
class Sink {
 public:
  CloudSegmenter::Handlers handlers() {
    return {.on_segmented = [this](const SegmentedCloud& cloud) { add(clouds_, cloud); },
            .on_warning = [this](const std::string& text) { add(warnings_, text); }};
  }
  std::optional<SegmentedCloud> cloud() { return next(clouds_); }
  std::optional<std::string> warning() { return next(warnings_); }

 private:
  template <typename T>
  void add(std::deque<T>& queue, const T& value) {
    const std::lock_guard lock(mutex_);
    queue.push_back(value);
    changed_.notify_all();
  }
  template <typename T>
  std::optional<T> next(std::deque<T>& queue) {
    std::unique_lock lock(mutex_);
    if (!changed_.wait_for(lock, 30s, [&] { return !queue.empty(); })) return std::nullopt;
    T value = std::move(queue.front());
    queue.pop_front();
    return value;
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<SegmentedCloud> clouds_;
  std::deque<std::string> warnings_;
};

IncomingCloud incoming(const CloudView& cloud, std::int64_t seconds, std::string frame = "camera_optical_frame") {
  auto strided = std::make_shared<codec::StridedCloud>(codec::encode_strided(cloud));
  IncomingCloud message;
  message.frame_id = std::move(frame);
  message.stamp = {seconds, 5};
  message.layout = strided->layout;
  message.data = strided->data;
  message.owner = strided;
  return message;
}

std::vector<std::uint32_t> labels_of(const SegmentedCloud& cloud) {
  const codec::PointField& field = cloud.layout.fields.back();
  EXPECT_EQ(field.name, "label");
  std::vector<std::uint32_t> labels(std::size_t{cloud.layout.width} * cloud.layout.height);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    std::memcpy(&labels[i], cloud.data.data() + i * cloud.layout.point_step + field.offset, sizeof(labels[i]));
  }
  return labels;
}

class CloudSegmenterTest : public testing::Test {
 protected:
  void SetUp() override {
    server::ServerOptions options;
    options.listen = "127.0.0.1:0";
    auto server = server::Server::start(options, server::core_backend_factory());
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    options_.client.address = server_->address();
    options_.time_to_live.reset();
  }

  std::unique_ptr<CloudSegmenter> start() {
    auto segmenter = CloudSegmenter::start(options_, sink_.handlers());
    EXPECT_TRUE(segmenter.ok()) << segmenter.status();
    return *std::move(segmenter);
  }

  std::unique_ptr<server::Server> server_;
  NodeOptions options_;
  Sink sink_;
};

TEST_F(CloudSegmenterTest, LabelsAreThoseOfTheCore) {
  const Cloud cloud = server::wall_with_box();
  const auto segmenter = start();
  ASSERT_TRUE(segmenter->add(incoming(cloud, 7)).ok());
  const auto result = sink_.cloud();
  ASSERT_TRUE(result);
  const auto expected = segment(cloud, {});
  ASSERT_TRUE(expected.ok()) << expected.status();
  EXPECT_EQ(labels_of(*result), expected->labels);
  EXPECT_EQ(result->frame_id, "camera_optical_frame");
  EXPECT_EQ(result->stamp, (Stamp{7, 5}));
  ASSERT_EQ(result->detections.size(), 2U) << "the wall and the box";
  const Detection& box = result->detections[1];
  EXPECT_EQ(box.id, 2U);
  EXPECT_NEAR(box.center.z(), 0.9, 0.01);
  EXPECT_NEAR(box.color[0], 200 / 255.0, 0.01);
  EXPECT_NEAR(box.orientation.norm(), 1, 1e-9);
  EXPECT_EQ(segmenter->counts().segmented, 1U);
}

TEST_F(CloudSegmenterTest, SmallSegmentsAreNoDetections) {
  options_.min_points = 2000;
  const auto segmenter = start();
  ASSERT_TRUE(segmenter->add(incoming(server::wall_with_box(), 7)).ok());
  const auto result = sink_.cloud();
  ASSERT_TRUE(result);
  EXPECT_EQ(result->detections.size(), 1U);
}

TEST_F(CloudSegmenterTest, AFrameThatIsFarAwayComesBackInItsOwnCoordinates) {
  const Cloud cloud = server::wall_with_box();
  // As a map has it: an offset that a float cannot carry, in fields of doubles.
  IncomingCloud far;
  auto data = std::make_shared<std::string>(cloud.size() * 24, '\0');
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const double position[] = {cloud.x[i] + 5e6, cloud.y[i] + 1e6, cloud.z[i] + 100.0};
    std::memcpy(data->data() + i * 24, position, 24);
  }
  far.frame_id = "map";
  far.layout.width = cloud.width;
  far.layout.height = cloud.height;
  far.layout.point_step = 24;
  far.layout.row_step = 24 * cloud.width;
  for (const char* name : {"x", "y", "z"}) {
    far.layout.fields.push_back(
        {name, static_cast<std::uint32_t>(8 * far.layout.fields.size()), codec::PointDatatype::kFloat64, 1});
  }
  far.data = *data;
  far.owner = data;
  const auto segmenter = start();
  ASSERT_TRUE(segmenter->add(std::move(far)).ok());
  const auto result = sink_.cloud();
  ASSERT_TRUE(result);
  ASSERT_FALSE(result->detections.empty());
  EXPECT_NEAR(result->detections[0].center.x(), 5e6, 1);
  EXPECT_NEAR(result->detections[0].center.z(), 101.2, 0.1);
}

TEST_F(CloudSegmenterTest, ACloudWithoutPointsComesBackAtOnce) {
  const auto segmenter = start();
  IncomingCloud empty = incoming(server::wall_with_box(), 3);
  empty.layout.width = empty.layout.row_step = 0;
  empty.data = {};
  ASSERT_TRUE(segmenter->add(std::move(empty)).ok());
  const auto result = sink_.cloud();
  ASSERT_TRUE(result);
  EXPECT_EQ(result->layout.fields.back().name, "label");
  EXPECT_TRUE(result->data.empty());
}

TEST_F(CloudSegmenterTest, OfTheCloudsThatWaitTheNewestIsKept) {
  options_.max_in_flight = 1;
  const auto segmenter = start();
  constexpr std::int64_t kLast = 40;
  for (std::int64_t i = 1; i <= kLast; ++i) {
    ASSERT_TRUE(segmenter->add(incoming(server::wall_with_box(), i)).ok());
  }
  std::int64_t before = 0, results = 0;
  while (before != kLast) {
    const auto result = sink_.cloud();
    ASSERT_TRUE(result) << "the last cloud was not segmented";
    EXPECT_GT(result->stamp.seconds, before);
    before = result->stamp.seconds;
    ++results;
  }
  EXPECT_LT(results, kLast) << "it was not behind";
}

TEST_F(CloudSegmenterTest, LabelsAreIdsOfTracksIfTheyAreWanted) {
  options_.track = true;
  const auto segmenter = start();
  for (std::int64_t i = 1; i <= 2; ++i) {
    ASSERT_TRUE(segmenter->add(incoming(server::wall_with_box(), i)).ok());
    const auto result = sink_.cloud();
    ASSERT_TRUE(result);
    ASSERT_FALSE(result->detections.empty());
    const std::vector<std::uint32_t> labels = labels_of(*result);
    EXPECT_THAT(labels, testing::Contains(result->detections[0].id));
  }
}

TEST_F(CloudSegmenterTest, BrokenCloudsAreRefused) {
  const auto segmenter = start();
  IncomingCloud cloud = incoming(server::wall_with_box(), 1);
  cloud.data.remove_suffix(1);
  EXPECT_THAT(std::string(segmenter->add(cloud).message()), HasSubstr("but its 120 rows have"));
  cloud = incoming(server::wall_with_box(), 1);
  cloud.layout.fields[2].name = "depth";
  EXPECT_EQ(segmenter->add(cloud).code(), absl::StatusCode::kInvalidArgument);
}

TEST_F(CloudSegmenterTest, WhatTheServerRefusesIsAWarning) {
  options_.view = View::world();
  options_.segmentation.range_max = 1;
  const auto segmenter = start();
  ASSERT_TRUE(segmenter->add(incoming(server::wall_with_box(), 1)).ok());
  const auto warning = sink_.warning();
  ASSERT_TRUE(warning);
  EXPECT_THAT(*warning, HasSubstr("'camera_optical_frame' was not segmented: "));
  EXPECT_THAT(*warning, HasSubstr("does not say where its sensor is"));
  EXPECT_EQ(segmenter->counts().failed, 1U);
}

TEST(CloudSegmenter, RefusesOptionsThatMakeNoSense) {
  NodeOptions options;
  options.client.address = "";
  EXPECT_EQ(CloudSegmenter::start(options, {}).status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace segserve::ros
