// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/codec/labeled_cloud.hpp"
#include "segserve/codec/length_unit.hpp"
#include "segserve/codec/warning.hpp"
#include "segserve/stop_token.hpp"

// Reads the clouds and depth images of a topic from a recording (MCAP, ROS 1 bag), one after the other.
namespace segserve::client {

/// A topic of a recording.
struct TopicInfo {
  std::string name;
  std::string type;            ///< name of the messages' schema, such as "sensor_msgs/msg/PointCloud2"
  std::string encoding;        ///< of the messages: "cdr", "ros1", "protobuf" ..
  std::uint64_t messages = 0;  ///< how many there are
  bool has_frames = false;     ///< whether it has clouds, or images with "depth" in its name
};

using RecordingTime = std::chrono::time_point<std::chrono::system_clock, std::chrono::nanoseconds>;

/// A cloud of a topic.
struct TopicFrame {
  std::uint64_t index = 0;      ///< counts the frames of the topic from 0
  RecordingTime log_time = {};  ///< when the message was recorded
  RecordingTime stamp = {};     ///< when the cloud was taken, by its header
  std::string frame_id = {};    ///< name of the cloud's coordinate frame
  /// Points in meters, with their view, the rule by which it was chosen, and warnings. INVALID_ARGUMENT if this message
  /// cannot be read, which does not concern those after it.
  absl::StatusOr<codec::LabeledCloud> content = codec::LabeledCloud{};
};

struct TopicReaderOptions {
  /// The topic has clouds (sensor_msgs/PointCloud2 of ROS 1 and 2, foxglove.PointCloud) or depth images
  /// (sensor_msgs/Image and CompressedImage, foxglove.RawImage and CompressedImage). Empty: the only topic of clouds
  /// or, if there are none, the only one of images with "depth" in its name.
  std::string topic = {};
  /// The topic that has the colors of images, aligned with the depth and of the same size. Each depth image gets the
  /// color image whose stamp is nearest, if it is within 0.1 s. Empty: there are no colors.
  std::string color_topic = {};
  /// The topic that has the camera of images (sensor_msgs/CameraInfo, foxglove.CameraCalibration). Empty: `camera_info`
  /// beside the topic, as ROS has it, or the only one of its namespace. A topic with "rect" in its name has the
  /// intrinsics P of rectified images, any other K; distortion is not corrected, of which a warning tells.
  std::string camera_info_topic = {};
  std::optional<View> view = std::nullopt;                              ///< replaces the one that the rule chooses
  codec::LengthUnit unit = codec::LengthUnit::kMeter;                   ///< of the coordinates of clouds
  bool keep_everything = false;                                         ///< see codec::ReadOptions; of clouds
  codec::DecodeLimits limits = {.max_bytes = std::uint64_t{1} << 30U};  ///< of a chunk, a message and a cloud
};

/// Reads frames in the order in which they were recorded. Holds one chunk of the recording in memory, and a few images.
///
///     auto reader = TopicReader::open("run.mcap", {.topic = "/points"});
///     for (auto frame = reader->next(); frame.ok() && *frame; frame = reader->next()) {
///       if ((*frame)->content.ok()) stream.send((*frame)->content->cloud, {.frame_id = (*frame)->frame_id});
///     }
///
/// Images are CAMERA clouds. The view of a cloud is chosen by this rule, of which view_rule tells:
///
///  0. WORLD with the sensor at (0, 0, 0) if a foxglove.PointCloud has a pose: its points lie in the sensor's frame.
///  1. CAMERA if every finite point has z > 0 and the name of the frame contains "optical"; points at (0, 0, 0), by
///     which drivers say that there is none, do not count. The same if the cloud is organized and its frame is none
///     that belongs to a map, a vehicle or a robot's part (map, odom, world, earth, base.., ..base, ..link).
///  2. WORLD with the sensor at (0, 0, 0) if the frame's name is that of a sensor (it contains lidar, laser, velodyne,
///     ouster, livox, hesai, scan, radar, sensor, camera, optical or depth), or the cloud is organized and its frame is
///     not one of those above: a driver's own cloud lies in the sensor's frame.
///  3. WORLD without a sensor otherwise: nothing tells where it was.
class TopicReader {
 public:
  /// NOT_FOUND if there is no such file. INVALID_ARGUMENT for a file of another kind, and for a topic that is not there
  /// or no frames can be made of; the message lists the topics. Others as next().
  static absl::StatusOr<TopicReader> open(const std::string& path, const TopicReaderOptions& options = {},
                                          const StopToken& stop = {});
  TopicReader(TopicReader&&) noexcept;
  TopicReader& operator=(TopicReader&&) noexcept;
  ~TopicReader();

  /// All topics of the recording, by name.
  const std::vector<TopicInfo>& topics() const;
  /// The topic whose frames are read.
  const TopicInfo& topic() const;

  /// The next frame; nothing at the end. INVALID_ARGUMENT for an exceeded limit or a compression that is not known,
  /// UNAVAILABLE if reading fails, CANCELLED and DEADLINE_EXCEEDED as `stop` says.
  absl::StatusOr<std::optional<TopicFrame>> next(const StopToken& stop = {});

  /// The parts of the recording that were not used so far, because they are damaged, or missing at the end.
  std::vector<codec::Warning> warnings() const;

 private:
  class State;
  explicit TopicReader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// The topics of a recording, by name: from its index or, without one, by reading all of it. Errors as
/// TopicReader::open.
absl::StatusOr<std::vector<TopicInfo>> list_topics(const std::string& path, const TopicReaderOptions& options = {},
                                                   const StopToken& stop = {});

/// Whether a file that begins with these bytes is a recording: one that TopicReader reads, or of which it can tell what
/// to do with it. 16 bytes are enough.
bool is_recording(std::string_view begin);

}  // namespace segserve::client
