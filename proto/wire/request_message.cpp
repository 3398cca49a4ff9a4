// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/request_message.hpp"

#include <string>
#include <utility>
#include <vector>

#include "core/base/status_macros.hpp"
#include "fmt/format.h"
#include "proto/wire/cloud_message.hpp"
#include "proto/wire/options_message.hpp"
#include "proto/wire/payload_blocks.hpp"
#include "proto/wire/prompts_message.hpp"
#include "proto/wire/status_message.hpp"
#include "proto/wire/track_message.hpp"

namespace segserve::wire {
namespace {

constexpr std::size_t kMaxIdBytes = 256;

void check_id(const std::string& id, const char* field, std::vector<FieldViolation>& faults) {
  if (id.size() > kMaxIdBytes) {
    faults.push_back({field, fmt::format("has {} bytes, but may have at most {}", id.size(), kMaxIdBytes)});
  }
}

Outputs parse_outputs(const v1::Outputs& message) {
  Outputs outputs{.labels = message.labels(),
                  .supervoxels = message.supervoxels(),
                  .tree = message.tree(),
                  .segments = message.segments()};
  for (const int accepted : message.accepted_compressions()) {
    if (accepted == v1::COMPRESSION_ZSTD) outputs.compression = Compression::kZstd;
  }
  return outputs;
}

void check_cloud(bool has_cloud, const v1::Cloud& cloud, std::vector<FieldViolation>& faults) {
  if (!has_cloud) {
    faults.push_back({"cloud", "is missing"});
    return;
  }
  for (FieldViolation& fault : violations(cloud)) faults.push_back(std::move(fault));
}

/// Checks that the header does not hold the bytes of the payload, but announces their number.
void check_announcement(const v1::FrameHeader& header, std::vector<FieldViolation>& faults) {
  if (payload_has_data(header.cloud())) {
    faults.push_back({"cloud", "holds bytes of the payload, which must come in chunks"});
  }
  if (const std::uint64_t sum = payload_bytes(header.cloud()); header.encoded_bytes() != sum) {
    faults.push_back({"encoded_bytes",
                      fmt::format("{} is not the sum of the blocks' encoded_bytes, {}", header.encoded_bytes(), sum)});
  }
}

void check_duration(bool is_set, const google::protobuf::Duration& duration, const char* field,
                    std::vector<FieldViolation>& faults) {
  constexpr std::int64_t kYearInSeconds = std::int64_t{365} * 24 * 60 * 60;
  constexpr std::int32_t kSecondInNanoseconds = 1'000'000'000;
  if (!is_set) return;
  if (duration.seconds() < 0 || duration.seconds() > kYearInSeconds || duration.nanos() < 0 ||
      duration.nanos() >= kSecondInNanoseconds) {
    faults.push_back(
        {field, fmt::format("is {} s and {} ns, but must be from 0 to 1 year", duration.seconds(), duration.nanos())});
  }
}

}  // namespace

v1::Compression to_message(Compression compression) {
  return compression == Compression::kZstd ? v1::COMPRESSION_ZSTD : v1::COMPRESSION_NONE;
}

v1::Outputs to_message(const Outputs& outputs) {
  v1::Outputs message;
  message.set_labels(outputs.labels);
  message.set_supervoxels(outputs.supervoxels);
  message.set_tree(outputs.tree);
  message.set_segments(outputs.segments);
  message.add_accepted_compressions(to_message(outputs.compression));
  return message;
}

absl::StatusOr<ParsedRequest> parse_request(const v1::SegmentRequest& request, const Options& defaults) {
  std::vector<FieldViolation> faults;
  check_id(request.request_id(), "request_id", faults);
  check_id(request.frame_id(), "frame_id", faults);
  check_cloud(request.has_cloud(), request.cloud(), faults);
  ParsedRequest parsed{from_message(request.options(), defaults, faults),
                       request.has_outputs() ? parse_outputs(request.outputs()) : Outputs()};
  if (request.has_prompts()) parsed.prompts = from_message(request.prompts(), faults);
  if (request.has_tracking()) parsed.tracking = from_message(request.tracking(), faults);
  RETURN_IF_ERROR(invalid_fields(faults));
  return parsed;
}

absl::StatusOr<ParsedRequest> parse_open(const v1::StreamOpen& open, const Options& defaults) {
  std::vector<FieldViolation> faults;
  check_id(open.client_name(), "client_name", faults);
  if (!v1::ResultOrder_IsValid(open.order())) faults.push_back({"order", fmt::format("{} is unknown", open.order())});
  if (!v1::WhenBehind_IsValid(open.when_behind())) {
    faults.push_back({"when_behind", fmt::format("{} is unknown", open.when_behind())});
  }
  ParsedRequest parsed{from_message(open.options(), defaults, faults),
                       open.has_outputs() ? parse_outputs(open.outputs()) : Outputs()};
  RETURN_IF_ERROR(invalid_fields(faults));
  return parsed;
}

absl::StatusOr<ParsedRequest> parse_frame(const v1::FrameHeader& header, const ParsedRequest& stream,
                                          const Options& defaults) {
  std::vector<FieldViolation> faults;
  check_id(header.request_id(), "request_id", faults);
  check_id(header.frame_id(), "frame_id", faults);
  check_cloud(header.has_cloud(), header.cloud(), faults);
  check_announcement(header, faults);
  check_duration(header.has_time_to_live(), header.time_to_live(), "time_to_live", faults);
  check_duration(header.has_age(), header.age(), "age", faults);
  ParsedRequest parsed = stream;
  if (header.has_options()) parsed.options = from_message(header.options(), defaults, faults);
  if (header.has_outputs()) parsed.outputs = parse_outputs(header.outputs());
  if (header.has_prompts()) parsed.prompts = from_message(header.prompts(), faults);
  if (header.has_tracking()) parsed.tracking = from_message(header.tracking(), faults);
  RETURN_IF_ERROR(invalid_fields(faults));
  return parsed;
}

}  // namespace segserve::wire
