// SPDX-License-Identifier: Apache-2.0
#include "client/recording/message_source.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "client/recording/bytes/recording_file.hpp"
#include "client/recording/mcap/mcap_reader.hpp"
#include "client/recording/mcap/mcap_records.hpp"
#include "client/recording/rosbag1/bag_reader.hpp"
#include "client/recording/rosbag1/bag_records.hpp"
#include "core/base/status_macros.hpp"

namespace segserve::recording {
namespace {

using std::string_view_literals::operator""sv;

constexpr std::string_view kSqlite = "SQLite format 3\0"sv;
constexpr std::string_view kRosBag = "#ROSBAG V"sv;

/// Why a file that begins with these bytes is none of ours.
absl::Status wrong_kind(std::string_view begin) {
  if (begin.starts_with(kSqlite)) {
    return absl::InvalidArgumentError(
        "this is a SQLite file, as ROS 2 records; MCAP can be read: `ros2 bag convert` makes it, with "
        "`storage_id: mcap` in its output options");
  }
  if (begin.starts_with(kRosBag)) {
    return absl::InvalidArgumentError("this is a ROS bag of an old version; 2.0 can be read: `rosbag fix` makes it");
  }
  if (begin.empty()) return absl::InvalidArgumentError("the file is empty");
  return absl::InvalidArgumentError("this is neither an MCAP file nor a ROS bag");
}

}  // namespace

const Schema& Definitions::schema_of(const Channel& channel) const {
  static const Schema kNone;
  const auto found = schemas.find(channel.schema);
  return found == schemas.end() ? kNone : found->second;
}

bool is_known_recording(std::string_view begin) {
  return begin.starts_with(kMcapMagic) || begin.starts_with(kSqlite) || begin.starts_with(kRosBag);
}

absl::StatusOr<std::unique_ptr<MessageSource>> open_source(const std::string& path, const codec::DecodeLimits& limits) {
  ASSIGN_OR_RETURN(RecordingFile file, RecordingFile::open(path));
  std::string begin;
  constexpr std::uint64_t kEnough = 16;
  RETURN_IF_ERROR(file.read(std::min(kEnough, file.size()), begin));
  if (begin.starts_with(kMcapMagic)) return McapReader::open(std::move(file), limits);
  if (begin.starts_with(kBagMagic)) return BagReader::open(std::move(file), limits);
  return wrong_kind(begin);
}

absl::StatusOr<Contents> read_contents(const std::string& path, const codec::DecodeLimits& limits,
                                       const StopToken& stop) {
  ASSIGN_OR_RETURN(const auto source, open_source(path, limits));
  ASSIGN_OR_RETURN(auto indexed, source->indexed_contents());
  if (indexed) return *std::move(indexed);
  Contents contents;
  while (true) {
    ASSIGN_OR_RETURN(const auto item, source->next(stop));
    if (!item) break;
    if (item->message) ++contents.messages[item->message->channel];
  }
  contents.definitions = source->definitions();
  if (contents.definitions.channels.empty() && !source->warnings().empty()) {
    return absl::InvalidArgumentError(source->warnings().front().message);
  }
  return contents;
}

}  // namespace segserve::recording
