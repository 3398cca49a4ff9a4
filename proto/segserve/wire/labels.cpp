#include "segserve/wire/labels.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "fmt/format.h"
#include "segserve/codec/labels.hpp"
#include "segserve/wire/block.hpp"
#include "segserve/wire/status.hpp"

namespace segserve::wire {
absl::StatusOr<v1alpha1::LabelArray> to_message(std::span<const std::uint32_t> labels,
                                                v1alpha1::Compression compression) {
  codec::EncodedLabels encoded = codec::encode_labels(labels);
  v1alpha1::LabelArray message;
  message.set_count(labels.size());
  message.set_bytes_per_label(encoded.bytes_per_label);
  absl::StatusOr<v1alpha1::Block> block = to_block(std::move(encoded.bytes), compression);
  if (!block.ok()) return block.status();
  *message.mutable_data() = *std::move(block);
  return message;
}

absl::StatusOr<std::vector<std::uint32_t>> from_message(const v1alpha1::LabelArray& message, std::uint64_t points,
                                                        std::uint32_t maximum, std::string_view name) {
  if (message.count() != points) {
    return malformed(fmt::format("{}: {} entries for {} points", name, message.count(), points));
  }
  const std::uint32_t width = message.bytes_per_label();
  if (width != 1 && width != 2 && width != 4) {
    return malformed(fmt::format("{}: {} bytes per label, but only 1, 2 and 4 exist", name, width));
  }
  std::string buffer;
  const absl::StatusOr<std::string_view> bytes = block_bytes(message.data(), points * width, name, buffer);
  if (!bytes.ok()) return bytes.status();
  absl::StatusOr<std::vector<std::uint32_t>> labels = codec::decode_labels(*bytes, width);
  if (!labels.ok()) return malformed(fmt::format("{}: {}", name, std::string(labels.status().message())));
  const auto largest = std::ranges::max_element(*labels);
  if (largest != labels->end() && *largest > maximum) {
    return malformed(fmt::format("{}: holds {}, though {} is the largest", name, *largest, maximum));
  }
  return labels;
}

}  // namespace segserve::wire
