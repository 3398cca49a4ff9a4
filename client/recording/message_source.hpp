// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/codec/warning.hpp"
#include "segserve/stop_token.hpp"

// The interface that every kind of recording has. The words are those of MCAP (https://mcap.dev/spec).
namespace segserve::recording {

/// Describes the messages of a channel.
struct Schema {
  std::string name;      ///< such as "sensor_msgs/msg/PointCloud2"
  std::string encoding;  ///< of `data`: "ros2msg", "ros1msg", "protobuf", "jsonschema" ..
  std::string data;
};

using StringMap = std::map<std::string, std::string>;

/// Where the messages of one writer and topic go.
struct Channel {
  std::uint16_t schema = 0;  ///< 0: none
  std::string topic;
  std::string message_encoding;  ///< "cdr", "ros1", "protobuf", "json" ..
  StringMap metadata;
};

struct Message {
  std::uint16_t channel = 0;
  std::uint32_t sequence = 0;
  std::uint64_t log_time = 0;  ///< nanoseconds since 1970 when it was recorded
  std::uint64_t publish_time = 0;
  std::string_view data;  ///< in memory of the source until its next call
};

/// A part that belongs to the recording as a whole: an attachment or a piece of metadata, as a record of MCAP.
struct Extra {
  std::uint8_t opcode = 0;
  std::string_view content;  ///< in memory of the source until its next call
};

/// One thing in a recording: a message, or else an extra.
struct Item {
  std::optional<Message> message;
  Extra extra;
};

/// The channels of a recording, each under its number.
struct Definitions {
  std::map<std::uint16_t, Schema> schemas;
  std::map<std::uint16_t, Channel> channels;

  /// The schema of a channel; an empty one if it has none.
  const Schema& schema_of(const Channel& channel) const;
};

/// The contents of a recording, without its messages.
struct Contents {
  Definitions definitions;
  std::map<std::uint16_t, std::uint64_t> messages;  ///< by channel
};

/// A recording that is read from its beginning to its end. It holds at most one chunk in memory.
class MessageSource {
 public:
  virtual ~MessageSource() = default;

  /// The next thing in the order of the file; nothing at its end. Damaged parts are left out, and `warnings` tell of
  /// them. UNAVAILABLE if reading fails, INVALID_ARGUMENT if a limit is exceeded, CANCELLED and DEADLINE_EXCEEDED as
  /// `stop` says.
  virtual absl::StatusOr<std::optional<Item>> next(const StopToken& stop) = 0;
  /// The channels that have come so far. A message's own are among them.
  virtual const Definitions& definitions() const = 0;
  /// The kind of messages that the file claims to have: "ros2", "ros1" and so on, or nothing.
  virtual const std::string& profile() const = 0;
  /// The parts of the file that were not used so far.
  virtual const std::vector<codec::Warning>& warnings() const = 0;
  /// The contents by the file's own index; nothing if it has none, or a damaged one. To be called before `next`.
  virtual absl::StatusOr<std::optional<Contents>> indexed_contents() = 0;
};

/// Opens an MCAP file or a ROS 1 bag. `limits.max_bytes` bounds a chunk and a message. INVALID_ARGUMENT names a file
/// of another kind and says what to do with it; other errors as RecordingFile::open.
absl::StatusOr<std::unique_ptr<MessageSource>> open_source(const std::string& path, const codec::DecodeLimits& limits);

/// Whether a file that begins with these bytes is of a kind that open_source reads, or can tell what to do with.
bool is_known_recording(std::string_view begin);

/// Lists the contents of a recording, from its index or, without one, by reading all of it.
absl::StatusOr<Contents> read_contents(const std::string& path, const codec::DecodeLimits& limits,
                                       const StopToken& stop);

}  // namespace segserve::recording
