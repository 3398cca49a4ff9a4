#include "segserve/codec/labels.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "segserve/codec/scalar.hpp"

namespace segserve::codec {
namespace {

template <typename T>
std::string narrow(std::span<const std::uint32_t> labels) {
  std::string bytes(labels.size() * sizeof(T), '\0');
  char* out = bytes.data();
  for (const std::uint32_t label : labels) {
    const T value = static_cast<T>(label);
    std::memcpy(out, &value, sizeof(T));
    out += sizeof(T);
  }
  return bytes;
}

template <typename T>
std::vector<std::uint32_t> widen(std::string_view bytes) {
  std::vector<std::uint32_t> labels(bytes.size() / sizeof(T));
  const auto* in = reinterpret_cast<const std::byte*>(bytes.data());
  for (std::uint32_t& label : labels) {
    label = load<T>(in);
    in += sizeof(T);
  }
  return labels;
}

}  // namespace

EncodedLabels encode_labels(std::span<const std::uint32_t> labels) {
  const std::uint32_t largest = labels.empty() ? 0 : *std::max_element(labels.begin(), labels.end());
  if (largest <= 0xFFU) return {narrow<std::uint8_t>(labels), 1};
  if (largest <= 0xFFFFU) return {narrow<std::uint16_t>(labels), 2};
  return {narrow<std::uint32_t>(labels), 4};
}

absl::StatusOr<std::vector<std::uint32_t>> decode_labels(std::string_view bytes, std::uint32_t bytes_per_label) {
  if (bytes_per_label != 1 && bytes_per_label != 2 && bytes_per_label != 4) {
    return absl::InvalidArgumentError(fmt::format("{} bytes per label; 1, 2 and 4 are possible", bytes_per_label));
  }
  if (bytes.size() % bytes_per_label != 0) {
    return absl::InvalidArgumentError(
        fmt::format("{} bytes are no whole number of labels of {} bytes", bytes.size(), bytes_per_label));
  }
  if (bytes_per_label == 1) return widen<std::uint8_t>(bytes);
  if (bytes_per_label == 2) return widen<std::uint16_t>(bytes);
  return widen<std::uint32_t>(bytes);
}

}  // namespace segserve::codec
