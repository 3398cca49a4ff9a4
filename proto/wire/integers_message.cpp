// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/integers_message.hpp"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "core/codec/common/packed_integers.hpp"
#include "fmt/format.h"
#include "proto/wire/block_message.hpp"
#include "proto/wire/status_message.hpp"

namespace segserve::wire {

absl::StatusOr<v1::IntegerArray> to_message(std::span<const std::uint32_t> values, v1::Compression compression) {
  codec::EncodedIntegers encoded = codec::encode_integers(values);
  v1::IntegerArray message;
  message.set_count(values.size());
  message.set_bytes_per_value(encoded.bytes_per_value);
  absl::StatusOr<v1::Block> block = to_block(std::move(encoded.bytes), compression);
  if (!block.ok()) return block.status();
  *message.mutable_data() = *std::move(block);
  return message;
}

absl::StatusOr<std::vector<std::uint32_t>> from_message(const v1::IntegerArray& message, std::uint64_t count,
                                                        std::uint32_t maximum, std::string_view name) {
  if (message.count() != count) {
    return malformed(fmt::format("{}: {} values, but must have {}", name, message.count(), count));
  }
  const std::uint32_t width = message.bytes_per_value();
  if (width != 1 && width != 2 && width != 4) {
    return malformed(fmt::format("{}: {} bytes per value, but only 1, 2 and 4 exist", name, width));
  }
  if (count > std::numeric_limits<std::uint64_t>::max() / width) {
    return malformed(fmt::format("{}: {} values of {} bytes do not fit into any memory", name, count, width));
  }
  std::string buffer;
  const absl::StatusOr<std::string_view> bytes = block_bytes(message.data(), count * width, name, buffer);
  if (!bytes.ok()) return bytes.status();
  absl::StatusOr<std::vector<std::uint32_t>> values = codec::decode_integers(*bytes, width);
  if (!values.ok()) return malformed(fmt::format("{}: {}", name, std::string(values.status().message())));
  const auto largest = std::ranges::max_element(*values);
  if (largest != values->end() && *largest > maximum) {
    return malformed(fmt::format("{}: holds {}, though {} is the largest", name, *largest, maximum));
  }
  return values;
}

}  // namespace segserve::wire
