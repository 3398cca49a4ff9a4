// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/integers_message.hpp"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "core/base/status_macros.hpp"
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
  ASSIGN_OR_RETURN(*message.mutable_data(), to_block(std::move(encoded.bytes), compression));
  return message;
}

absl::StatusOr<std::vector<std::uint32_t>> from_message(const v1::IntegerArray& message, std::uint64_t count,
                                                        std::uint32_t maximum, std::string_view name) {
  if (message.count() != count) {
    return malformed(fmt::format("{}: has {} values, but must have {}", name, message.count(), count));
  }
  const std::uint32_t width = message.bytes_per_value();
  if (width != 1 && width != 2 && width != 4) {
    return malformed(fmt::format("{}: has {} bytes per value, but must have 1, 2 or 4", name, width));
  }
  if (count > std::numeric_limits<std::uint64_t>::max() / width) {
    return malformed(fmt::format("{}: {} values of {} bytes are more than any memory can hold", name, count, width));
  }
  std::string buffer;
  ASSIGN_OR_RETURN(const std::string_view bytes, block_bytes(message.data(), count * width, name, buffer));
  absl::StatusOr<std::vector<std::uint32_t>> values = codec::decode_integers(bytes, width);
  if (!values.ok()) return malformed(name, values.status());
  const auto largest = std::ranges::max_element(*values);
  if (largest != values->end() && *largest > maximum) {
    return malformed(fmt::format("{}: holds {}, but the largest allowed value is {}", name, *largest, maximum));
  }
  return values;
}

}  // namespace segserve::wire
