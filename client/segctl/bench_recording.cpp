// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/bench_recording.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "client/segctl/input_file.hpp"
#include "client/segctl/messages.hpp"
#include "client/segctl/sequence.hpp"
#include "core/base/status_macros.hpp"
#include "fmt/format.h"
#include "segserve/client/topic_reader.hpp"
#include "segserve/codec/cloud_file.hpp"

namespace segserve::segctl {
namespace {

constexpr std::uint64_t kMostBytes = std::uint64_t{2} << 30U;
constexpr std::uint64_t kPointBytes = 16;

/// Gathers clouds with the times of their capture, seconds.
class TimedClouds {
 public:
  /// False if the cloud is one too many.
  bool add(double time, Cloud cloud) {
    bytes_ += kPointBytes * cloud.size();
    if (bytes_ > kMostBytes) return false;
    clouds_.push_back({time, std::make_shared<const Cloud>(std::move(cloud))});
    return true;
  }
  void leave_out() { ++unread_; }

  /// Warns of what was left out of `all` clouds.
  void warn(std::size_t all) const {
    if (bytes_ > kMostBytes) {
      print_warning(
          fmt::format("the first {} frames of {} are used: more would take more than 2 GiB", clouds_.size(), all));
    }
    if (unread_ > 0) {
      print_warning(fmt::format("{} frames cannot be read or have no points: they are left out", unread_));
    }
  }

  /// The clouds by their times, of which the first is 0. INVALID_ARGUMENT, which names their origin, if there are no
  /// two different times.
  absl::StatusOr<bench::FrameSource> source(const std::string& origin) && {
    std::ranges::stable_sort(clouds_, {}, &TimedCloud::time);
    if (clouds_.empty() || clouds_.front().time == clouds_.back().time) {
      return absl::InvalidArgumentError(fmt::format("{} has no two frames at different times to replay", origin));
    }
    bench::FrameSource source;
    for (TimedCloud& cloud : clouds_) {
      source.times.push_back(cloud.time - clouds_.front().time);
      source.clouds.push_back(std::move(cloud.cloud));
    }
    return source;
  }

 private:
  struct TimedCloud {
    double time = 0;
    std::shared_ptr<const Cloud> cloud;
  };

  std::vector<TimedCloud> clouds_;
  std::uint64_t bytes_ = 0;
  std::size_t unread_ = 0;
};

absl::StatusOr<client::TopicReader> open_reader(const std::string& path, const RecordingFlags& flags) {
  client::TopicReaderOptions options;
  options.topic = flags.topic;
  options.color_topic = flags.color_topic;
  options.camera_info_topic = flags.camera_info_topic;
  return client::TopicReader::open(path, options);
}

absl::StatusOr<codec::LabeledCloud> read_cloud(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string bytes, read_input(path));
  return codec::decode_cloud(std::as_bytes(std::span(bytes)), {});
}

}  // namespace

absl::StatusOr<bench::FrameSource> load_recording(const std::string& path, const RecordingFlags& flags) {
  ASSIGN_OR_RETURN(client::TopicReader reader, open_reader(path, flags));
  TimedClouds clouds;
  std::optional<client::RecordingTime> first;
  while (true) {
    ASSIGN_OR_RETURN(auto frame, reader.next());
    if (!frame) break;
    if (!frame->content.ok() || frame->content->cloud.size() == 0) {
      clouds.leave_out();
      continue;
    }
    if (!first) first = frame->log_time;
    const double time = std::chrono::duration<double>(frame->log_time - *first).count();
    if (!clouds.add(time, std::move(frame->content->cloud))) break;
  }
  clouds.warn(reader.topic().messages);
  for (const codec::Warning& warning : reader.warnings()) print_warning(warning.message);
  return std::move(clouds).source(fmt::format("{}: topic {}", path, reader.topic().name));
}

absl::StatusOr<bench::FrameSource> load_sequence(const std::string& folder) {
  constexpr double kAnyRate = 1;  // The folder tells the times.
  ASSIGN_OR_RETURN(const Sequence sequence, read_sequence(folder, kAnyRate));
  TimedClouds clouds;
  for (const SequenceFrame& frame : sequence.frames) {
    auto content = read_cloud((std::filesystem::path(folder) / frame.file).string());
    if (!content.ok() || content->cloud.size() == 0) {
      clouds.leave_out();
    } else if (!clouds.add(frame.time, std::move(content->cloud))) {
      break;
    }
  }
  clouds.warn(sequence.frames.size());
  return std::move(clouds).source(folder);
}

}  // namespace segserve::segctl
