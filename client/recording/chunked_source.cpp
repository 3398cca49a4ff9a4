// SPDX-License-Identifier: Apache-2.0
#include "client/recording/chunked_source.hpp"

#include <fmt/format.h>

#include <utility>

#include "core/base/status_macros.hpp"

namespace segserve::recording {
namespace {

/// The most that all schemas and channels of a file may have together. Real ones have some ten kB.
constexpr std::uint64_t kMaxDefinitionBytes = std::uint64_t{64} << 20U;
constexpr std::size_t kMaxWarnings = 20;

}  // namespace

ChunkedSource::ChunkedSource(RecordingFile file, const codec::DecodeLimits& limits)
    : file_(std::move(file)), limits_(limits) {}

absl::StatusOr<std::optional<Item>> ChunkedSource::next(const StopToken& stop) {
  std::optional<Item> item;
  while (!item) {
    RETURN_IF_ERROR(stop.check());
    if (!rest_of_chunk_.empty()) {
      ASSIGN_OR_RETURN(const bool is_whole, take_record_of_chunk(rest_of_chunk_, item));
      if (is_whole) continue;
      warn(fmt::format("the chunk at byte {} is damaged behind its byte {}: what follows in it is left out", chunk_at_,
                       chunk_.size() - rest_of_chunk_.size()));
      rest_of_chunk_ = {};
    } else {
      if (at_end_) return std::nullopt;
      ASSIGN_OR_RETURN(const bool has_more, read_record(stop, item));
      at_end_ = !has_more;
    }
  }
  return item;
}

void ChunkedSource::open_records(std::string records, std::uint64_t at) {
  chunk_ = std::move(records);
  rest_of_chunk_ = chunk_;
  chunk_at_ = at;
}

absl::Status ChunkedSource::check_size(std::string_view kind, std::uint64_t at, std::uint64_t bytes) const {
  if (bytes <= limits_.max_bytes) return absl::OkStatus();
  return codec::over_limit(
      fmt::format("the {} at byte {} has {} bytes, above the limit of {}", kind, at, bytes, limits_.max_bytes),
      {"max_bytes", bytes, limits_.max_bytes});
}

absl::Status ChunkedSource::count_definition(std::uint64_t bytes) {
  definition_bytes_ += bytes;
  if (definition_bytes_ <= kMaxDefinitionBytes) return absl::OkStatus();
  return codec::over_limit(fmt::format("schemas and channels have more than {} bytes", kMaxDefinitionBytes),
                           {"max_bytes", definition_bytes_, kMaxDefinitionBytes});
}

void ChunkedSource::warn(std::string message) {
  if (warnings_.size() == kMaxWarnings) message = "there is more damage than is told here";
  if (warnings_.size() <= kMaxWarnings) warnings_.push_back({codec::WarningReason::kRowsNotUsed, std::move(message)});
}

void ChunkedSource::warn_of_end_within_record(std::uint64_t at) {
  warn(fmt::format("the file ends within the record at byte {}, as after a crash: it is read up to there", at));
}

void ChunkedSource::warn_of_damaged(std::string_view kind, std::uint64_t at) {
  warn(fmt::format("the {} at byte {} is damaged and left out", kind, at));
}

}  // namespace segserve::recording
