// SPDX-License-Identifier: Apache-2.0
#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "client/recording/topic/frame_reader.hpp"
#include "client/recording/topic/labeled_message.hpp"

namespace segserve::recording {
namespace {

const client::TopicReaderOptions kOptions{.limits = {.max_points = 100'000, .max_bytes = 4'000'000}};

/// A file in memory.
class MemoryFile {
 public:
  MemoryFile(const std::uint8_t* data, std::size_t size) : file_(memfd_create("recording", 0)) {
    if (file_ < 0 || write(file_, data, size) != static_cast<ssize_t>(size)) std::abort();
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() { close(file_); }
  std::string path() const { return "/proc/self/fd/" + std::to_string(file_); }

 private:
  int file_;
};

void expect_words(const absl::Status& status) {
  if (!status.ok() && (!absl::IsInvalidArgument(status) || status.message().empty())) std::abort();
}

/// Reads all frames, and gives each of them labels.
void read_frames(FrameReader& reader) {
  while (true) {
    const auto recorded = reader.next(nullptr, {});
    expect_words(recorded.status());
    if (!recorded.ok() || !*recorded) return;
    const auto& content = (*recorded)->frame.content;
    expect_words(content.status());
    if (!content.ok()) continue;
    if (content->cloud.size() > kOptions.limits.max_points) std::abort();
    expect_words(labeled_message(**recorded, std::vector<std::uint32_t>(content->cloud.size())).status());
  }
}

}  // namespace
}  // namespace segserve::recording

// Recordings: MCAP files and ROS 1 bags.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace segserve::recording;
  const MemoryFile file(data, size);
  auto reader = FrameReader::open(file.path(), kOptions, {});
  expect_words(reader.status());
  if (reader.ok()) read_frames(*reader);
  return 0;
}
