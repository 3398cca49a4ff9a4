// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "client/recording/message_source.hpp"

// The records of ROS 1 bags, version 2.0 (http://wiki.ros.org/Bags/Format/2.0). All numbers are little-endian.
namespace segserve::recording {

inline constexpr std::string_view kBagMagic = "#ROSBAG V2.0\n";

/// The kinds of records that are read.
enum BagOp : std::uint8_t {
  kBagMessage = 0x02,
  kBagHeader = 0x03,
  kBagChunk = 0x05,
  kBagChunkInfo = 0x06,
  kBagConnection = 0x07,
};

/// Fields by name, as the headers of records and connections have them.
using BagFields = std::map<std::string_view, std::string_view>;

/// Reads fields; nothing if they are damaged.
std::optional<BagFields> parse_bag_fields(std::string_view bytes);
/// The number in a field, which has that many bytes; nothing if there is none.
std::optional<std::uint64_t> bag_number(const BagFields& fields, std::string_view name, std::size_t bytes);
/// The kind of a record; 0 if it does not say.
std::uint8_t bag_op(const BagFields& fields);

struct BagRecord {
  BagFields fields;
  std::string_view data;
};

/// Takes the next record from the front of `bytes`; nothing if it is not whole, or damaged.
std::optional<BagRecord> take_bag_record(std::string_view& bytes);

/// A connection as MCAP says the same: its number there, schema and channel.
struct BagConnection {
  std::uint16_t number = 0;
  Schema schema;
  Channel channel;
};

/// Nothing if a field is missing, or the connection has a number above 65,534.
std::optional<BagConnection> parse_bag_connection(const BagRecord& record);
/// The message has no sequence number. Returns nothing in the cases above.
std::optional<Message> parse_bag_message(const BagRecord& record);

}  // namespace segserve::recording
