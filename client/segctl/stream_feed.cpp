// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/stream_feed.hpp"

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <span>
#include <system_error>
#include <utility>

#include "client/segctl/input_file.hpp"
#include "client/segctl/sequence.hpp"
#include "core/base/status_macros.hpp"
#include "fmt/format.h"
#include "segserve/client/topic_reader.hpp"
#include "segserve/codec/cloud_file.hpp"
#include "segserve/codec/read_options.hpp"

namespace segserve::segctl {
namespace {

namespace fs = std::filesystem;

absl::StatusOr<codec::LabeledCloud> load_cloud(const std::string& path, const std::optional<View>& view) {
  ASSIGN_OR_RETURN(const std::string bytes, read_input(path));
  return codec::decode_cloud(std::as_bytes(std::span(bytes)), {}, {.view = view});
}

class FileFeed : public FrameFeed {
 public:
  FileFeed(std::string folder, Sequence sequence, std::optional<View> view)
      : folder_(std::move(folder)),
        frames_(std::move(sequence.frames)),
        view_(std::move(view)),
        has_times_(sequence.has_times) {}

  absl::StatusOr<std::optional<FeedFrame>> next() override {
    if (next_ == frames_.size()) return std::nullopt;
    const SequenceFrame& frame = frames_[next_++];
    const std::string path = folder_.empty() ? frame.file : (fs::path(folder_) / frame.file).string();
    return FeedFrame{input_name(path), frame.time - frames_.front().time, load_cloud(path, view_), frame.pose, {}};
  }
  bool has_times() const override { return has_times_; }

 private:
  const std::string folder_;
  const std::vector<SequenceFrame> frames_;
  const std::optional<View> view_;
  const bool has_times_;
  std::size_t next_ = 0;
};

class RecordingFeed : public FrameFeed {
 public:
  RecordingFeed(std::string path, client::TopicReader reader) : path_(std::move(path)), reader_(std::move(reader)) {}

  absl::StatusOr<std::optional<FeedFrame>> next() override {
    ASSIGN_OR_RETURN(auto frame, reader_.next());
    if (!frame) return std::nullopt;
    if (!first_) first_ = frame->log_time;
    const double time = std::chrono::duration<double>(frame->log_time - *first_).count();
    return FeedFrame{fmt::format("{}: frame {}", path_, frame->index), time, std::move(frame->content), std::nullopt,
                     std::move(frame->frame_id)};
  }
  bool has_times() const override { return true; }

 private:
  const std::string path_;
  client::TopicReader reader_;
  std::optional<client::RecordingTime> first_;
};

class MovingFeed : public FrameFeed {
 public:
  explicit MovingFeed(synth::MovingTabletop scene) : scene_(std::move(scene)) {}

  absl::StatusOr<std::optional<FeedFrame>> next() override {
    if (next_ == scene_.frames()) return std::nullopt;
    synth::MovingFrame frame = scene_.frame(next_);
    codec::LabeledCloud content;
    content.cloud = std::move(frame.scene.cloud);
    content.label = std::move(frame.scene.label);
    return FeedFrame{fmt::format("frame {}", next_++), frame.time, std::move(content), frame.pose, {}};
  }
  bool has_times() const override { return true; }

 private:
  const synth::MovingTabletop scene_;
  std::uint32_t next_ = 0;
};

absl::StatusOr<std::unique_ptr<FrameFeed>> open_recording(const FeedOptions& options) {
  client::TopicReaderOptions reading;
  reading.topic = options.recording.topic;
  reading.color_topic = options.recording.color_topic;
  reading.camera_info_topic = options.recording.camera_info_topic;
  reading.view = options.view;
  ASSIGN_OR_RETURN(auto reader, client::TopicReader::open(options.inputs.front(), reading));
  return std::make_unique<RecordingFeed>(options.inputs.front(), std::move(reader));
}

absl::StatusOr<std::unique_ptr<FrameFeed>> open_folder(const FeedOptions& options) {
  const std::string& folder = options.inputs.front();
  constexpr double kAnyRate = 1;  // It is not used if there are no times.
  ASSIGN_OR_RETURN(Sequence sequence, read_sequence(folder, kAnyRate));
  return std::make_unique<FileFeed>(folder, std::move(sequence), options.view);
}

}  // namespace

absl::StatusOr<std::unique_ptr<FrameFeed>> open_feed(const FeedOptions& options) {
  if (options.moving) {
    ASSIGN_OR_RETURN(auto scene, synth::MovingTabletop::make(*options.moving));
    return std::make_unique<MovingFeed>(std::move(scene));
  }
  const bool is_one = options.inputs.size() == 1;
  if (is_one && is_recording_file(options.inputs.front())) return open_recording(options);
  if (options.recording.given()) {
    return absl::InvalidArgumentError(
        "--topic, --color-topic and --camera-info-topic are for one recording (MCAP or ROS 1 bag)");
  }
  std::error_code error;
  if (is_one && fs::is_directory(options.inputs.front(), error)) return open_folder(options);
  Sequence files;
  for (const std::string& path : options.inputs) {
    if (fs::is_directory(path, error) || is_recording_file(path)) {
      return absl::InvalidArgumentError(
          fmt::format("{}: a folder or a recording must be the only INPUT; several are files of clouds", path));
    }
    if (path != "-" && !fs::exists(path, error)) return absl::NotFoundError(fmt::format("there is no {}", path));
    files.frames.push_back({path, 0.0, std::nullopt});
  }
  return std::make_unique<FileFeed>("", std::move(files), options.view);
}

}  // namespace segserve::segctl
