// SPDX-License-Identifier: Apache-2.0
#include "segserve/client/result_file.hpp"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <limits>
#include <optional>

#include "core/base/status_macros.hpp"
#include "fmt/format.h"
#include "proto/wire/byte_run.hpp"
#include "proto/wire/result_message.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/v1/segment.pb.h"

namespace segserve::client {
namespace {

constexpr std::string_view kMagic = "segserve-result ";
constexpr std::string_view kVersion = "3";
constexpr std::string_view kVersionWithoutFingerprint = "2";
constexpr std::size_t kMaxHeader = 64;  // bytes
/// Protobuf reads no larger message.
constexpr std::size_t kMaxPayload = std::numeric_limits<std::int32_t>::max();

struct Header {
  std::uint64_t payload_bytes = 0;
  std::uint32_t crc = 0;
  std::optional<CloudFingerprint> cloud = std::nullopt;
};

/// Cuts the first word off a line.
std::string_view take_word(std::string_view& line) {
  const std::size_t end = std::min(line.find(' '), line.size());
  const std::string_view word = line.substr(0, end);
  line.remove_prefix(std::min(end + 1, line.size()));
  return word;
}

template <typename Number>
std::optional<Number> parse(std::string_view text, int base) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number, base);
  const bool whole = error == std::errc{} && end == text.data() + text.size();
  return whole ? std::optional(number) : std::nullopt;
}

absl::Status damaged_line() { return absl::InvalidArgumentError("the first line of the saved result is damaged"); }

absl::StatusOr<Header> parse_line(std::string_view line) {
  if (!line.starts_with(kMagic)) return absl::InvalidArgumentError("this is not a result that segctl saved");
  line.remove_prefix(kMagic.size());
  const std::string_view version = take_word(line);
  if (version != kVersion && version != kVersionWithoutFingerprint) {
    return absl::InvalidArgumentError(fmt::format("the saved result has version '{}', but this program reads {} and {}",
                                                  version, kVersionWithoutFingerprint, kVersion));
  }
  const auto payload_bytes = parse<std::uint64_t>(take_word(line), 10);
  const auto crc = parse<std::uint32_t>(take_word(line), 16);
  if (!payload_bytes || !crc) return damaged_line();
  Header header{*payload_bytes, *crc};
  if (version == kVersion) {
    const auto coordinates = parse<std::uint32_t>(take_word(line), 16);
    const auto colors = parse<std::uint32_t>(take_word(line), 16);
    if (!coordinates || !colors) return damaged_line();
    header.cloud = CloudFingerprint{*coordinates, *colors};
  }
  return line.empty() ? absl::StatusOr<Header>(header) : damaged_line();
}

struct File {
  Header header;
  std::string_view payload;
};

absl::StatusOr<File> split(std::string_view bytes) {
  const std::size_t end_of_line = bytes.substr(0, kMaxHeader).find('\n');
  const bool has_line = end_of_line != std::string_view::npos;
  ASSIGN_OR_RETURN(const Header header, parse_line(bytes.substr(0, has_line ? end_of_line : kMaxHeader)));
  if (!has_line) return absl::InvalidArgumentError("the saved result is truncated in its first line");
  return File{header, bytes.substr(end_of_line + 1)};
}

absl::Status check_payload(std::string_view payload, const Header& header) {
  if (payload.size() != header.payload_bytes) {
    return absl::InvalidArgumentError(fmt::format(
        "the saved result is {}: it has {} bytes after its first line instead of {}",
        payload.size() < header.payload_bytes ? "truncated" : "too long", payload.size(), header.payload_bytes));
  }
  if (payload.size() > kMaxPayload) {
    return absl::InvalidArgumentError(
        fmt::format("the saved result has {} bytes, more than the {} that can be read", payload.size(), kMaxPayload));
  }
  if (wire::crc32(0, payload) != header.crc) {
    return absl::InvalidArgumentError("the saved result is damaged: its checksum differs");
  }
  return absl::OkStatus();
}

/// The bytes after the first line.
absl::StatusOr<std::string> encode_payload(const Result& result) {
  const wire::Outputs outputs{.labels = true,
                              .supervoxels = true,
                              .tree = true,
                              .segments = !result.segmentation.statistics.empty(),
                              .compression = wire::Compression::kZstd};
  v1::SegmentResponse response;
  ASSIGN_OR_RETURN(*response.mutable_result(), wire::to_message(result, outputs));
  if (response.ByteSizeLong() > kMaxPayload) {
    return absl::InvalidArgumentError(fmt::format(
        "the result is too large for a file: {} bytes, at most {} are allowed", response.ByteSizeLong(), kMaxPayload));
  }
  return response.SerializeAsString();
}

}  // namespace

absl::StatusOr<std::string> encode_result_file(const Result& result, const CloudFingerprint& cloud) {
  ASSIGN_OR_RETURN(const std::string payload, encode_payload(result));
  return fmt::format("{}{} {} {:08x} {:08x} {:08x}\n", kMagic, kVersion, payload.size(), wire::crc32(0, payload),
                     cloud.coordinates, cloud.colors) +
         payload;
}

absl::StatusOr<std::string> encode_result_file(const Result& result) {
  ASSIGN_OR_RETURN(const std::string payload, encode_payload(result));
  return fmt::format("{}{} {} {:08x}\n", kMagic, kVersionWithoutFingerprint, payload.size(), wire::crc32(0, payload)) +
         payload;
}

absl::StatusOr<std::optional<CloudFingerprint>> fingerprint_in_result_file(std::string_view bytes) {
  ASSIGN_OR_RETURN(const File file, split(bytes));
  return file.header.cloud;
}

absl::StatusOr<Result> decode_result_file(std::string_view bytes) {
  ASSIGN_OR_RETURN(const File file, split(bytes));
  const std::string_view payload = file.payload;
  RETURN_IF_ERROR(check_payload(payload, file.header));

  v1::SegmentResponse response;
  if (!response.ParseFromArray(payload.data(), static_cast<int>(payload.size()))) {
    return absl::InvalidArgumentError("the saved result is damaged: it does not hold a SegmentResponse");
  }
  const std::uint64_t points = response.result().summary().points();
  if (const std::uint64_t allowed = codec::DecodeLimits{}.max_points; points > allowed) {
    return absl::InvalidArgumentError(
        fmt::format("the saved result claims {} points, more than the {} that are allowed", points, allowed));
  }
  auto result = wire::from_message(response.result(), points);
  if (!result.ok()) {
    return absl::InvalidArgumentError(
        fmt::format("the saved result is damaged: {}", std::string(result.status().message())));
  }
  if (result->segmentation.supervoxels.size() != points ||
      result->segmentation.tree.leaf_count() != result->supervoxels) {
    return absl::InvalidArgumentError("the saved result is damaged: it lacks supervoxels or the tree");
  }
  return result;
}

}  // namespace segserve::client
