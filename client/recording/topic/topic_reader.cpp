// SPDX-License-Identifier: Apache-2.0
#include "segserve/client/topic_reader.hpp"

#include <utility>

#include "client/recording/topic/frame_reader.hpp"
#include "client/recording/topic/topic_list.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"

namespace segserve::client {

class TopicReader::State {
 public:
  explicit State(recording::FrameReader opened) : frames(std::move(opened)) {}
  recording::FrameReader frames;
};

TopicReader::TopicReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
TopicReader::TopicReader(TopicReader&&) noexcept = default;
TopicReader& TopicReader::operator=(TopicReader&&) noexcept = default;
TopicReader::~TopicReader() = default;

absl::StatusOr<TopicReader> TopicReader::open(const std::string& path, const TopicReaderOptions& options,
                                              const StopToken& stop) {
  ASSIGN_OR_RETURN(auto frames, recording::FrameReader::open(path, options, stop));
  return TopicReader(std::make_unique<State>(std::move(frames)));
}

const std::vector<TopicInfo>& TopicReader::topics() const { return state_->frames.topics(); }

const TopicInfo& TopicReader::topic() const { return state_->frames.topic(); }

absl::StatusOr<std::optional<TopicFrame>> TopicReader::next(const StopToken& stop) {
  ASSIGN_OR_RETURN(auto recorded, state_->frames.next(nullptr, stop));
  if (!recorded) return std::nullopt;
  return std::move(recorded->frame);
}

std::vector<codec::Warning> TopicReader::warnings() const { return state_->frames.warnings(); }

absl::StatusOr<std::vector<TopicInfo>> list_topics(const std::string& path, const TopicReaderOptions& options,
                                                   const StopToken& stop) {
  const auto contents = recording::read_contents(path, options.limits, stop);
  if (contents.ok()) return recording::topic_list(*contents);
  return absl::IsInvalidArgument(contents.status()) ? with_prefix(path, contents.status()) : contents.status();
}

bool is_recording(std::string_view begin) { return recording::is_known_recording(begin); }

}  // namespace segserve::client
