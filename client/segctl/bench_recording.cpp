// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/bench_recording.hpp"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "client/segctl/messages.hpp"
#include "core/base/status_macros.hpp"
#include "fmt/format.h"
#include "segserve/client/topic_reader.hpp"

namespace segserve::segctl {
namespace {

constexpr std::uint64_t kMostBytes = std::uint64_t{2} << 30U;
constexpr std::uint64_t kPointBytes = 16;

struct RecordedCloud {
  client::RecordingTime time;
  std::shared_ptr<const Cloud> cloud;
};

absl::StatusOr<client::TopicReader> open_reader(const std::string& path, const RecordingFlags& flags) {
  client::TopicReaderOptions options;
  options.topic = flags.topic;
  options.color_topic = flags.color_topic;
  options.camera_info_topic = flags.camera_info_topic;
  return client::TopicReader::open(path, options);
}

absl::StatusOr<std::vector<RecordedCloud>> read_clouds(client::TopicReader& reader) {
  std::vector<RecordedCloud> clouds;
  std::uint64_t bytes = 0;
  std::size_t unread = 0;
  while (true) {
    ASSIGN_OR_RETURN(auto frame, reader.next());
    if (!frame) break;
    if (!frame->content.ok() || frame->content->cloud.size() == 0) {
      ++unread;
      continue;
    }
    bytes += kPointBytes * frame->content->cloud.size();
    if (bytes > kMostBytes) {
      print_warning(fmt::format("the first {} frames of {} are used: more would take more than 2 GiB", clouds.size(),
                                reader.topic().messages));
      break;
    }
    clouds.push_back({frame->log_time, std::make_shared<const Cloud>(std::move(frame->content->cloud))});
  }
  if (unread > 0) print_warning(fmt::format("{} frames cannot be read or have no points: they are left out", unread));
  for (const codec::Warning& warning : reader.warnings()) print_warning(warning.message);
  return clouds;
}

}  // namespace

absl::StatusOr<bench::FrameSource> load_recording(const std::string& path, const RecordingFlags& flags) {
  ASSIGN_OR_RETURN(client::TopicReader reader, open_reader(path, flags));
  ASSIGN_OR_RETURN(std::vector<RecordedCloud> clouds, read_clouds(reader));
  std::ranges::stable_sort(clouds, {}, &RecordedCloud::time);
  if (clouds.empty() || clouds.front().time == clouds.back().time) {
    return absl::InvalidArgumentError(
        fmt::format("{}: topic {} has no two frames at different times to replay", path, reader.topic().name));
  }
  bench::FrameSource source;
  for (RecordedCloud& cloud : clouds) {
    source.times.push_back(std::chrono::duration<double>(cloud.time - clouds.front().time).count());
    source.clouds.push_back(std::move(cloud.cloud));
  }
  return source;
}

}  // namespace segserve::segctl
