// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/recording_output.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include "client/recording/topic/labeled_message.hpp"
#include "core/base/status_macros.hpp"
#include "fmt/format.h"

namespace segserve::segctl {
namespace {

namespace fs = std::filesystem;

absl::Status cannot_write_recording(const std::string& path, int error) {
  return absl::UnavailableError(
      fmt::format("cannot write {}: {}", path == "-" ? "standard output" : path, std::strerror(error)));
}

/// The file that a link leads to, so that the link survives.
std::string file_behind(const std::string& path) {
  std::error_code error;
  const fs::path target = fs::weakly_canonical(path, error);
  return error ? path : target.string();
}

bool can_be_renamed_over(const std::string& path) {
  std::error_code error;
  const fs::file_type type = fs::status(path, error).type();
  return type == fs::file_type::not_found || type == fs::file_type::regular;
}

}  // namespace

absl::StatusOr<RecordingOutput> RecordingOutput::create(const std::string& path, const std::string& profile) {
  if (path == "-") return RecordingOutput(path, "", File(stdout), profile);
  const std::string target = file_behind(path);
  const std::string temporary = can_be_renamed_over(target) ? fmt::format("{}.tmp-{}", target, getpid()) : "";
  File file(std::fopen(temporary.empty() ? target.c_str() : temporary.c_str(), "wb"));
  if (file == nullptr) return cannot_write_recording(path, errno);
  return RecordingOutput(target, temporary, std::move(file), profile);
}

RecordingOutput::RecordingOutput(std::string path, std::string temporary, File file, const std::string& profile)
    : path_(std::move(path)), temporary_(std::move(temporary)), file_(std::move(file)) {
  const auto sink = [to = file_.get(), name = path_](std::string_view bytes) {
    if (std::fwrite(bytes.data(), 1, bytes.size(), to) == bytes.size()) return absl::OkStatus();
    return cannot_write_recording(name, errno);
  };
  writer_ = std::make_unique<recording::McapWriter>(sink, profile);
}

RecordingOutput::~RecordingOutput() {
  if (file_ == nullptr || temporary_.empty()) return;
  std::error_code ignored;
  fs::remove(temporary_, ignored);
}

absl::Status RecordingOutput::define(std::uint16_t number, const recording::Definitions& definitions) {
  const recording::Channel& channel = definitions.channels.at(number);
  if (const auto schema = definitions.schemas.find(channel.schema); schema != definitions.schemas.end()) {
    RETURN_IF_ERROR(writer_->define(schema->first, schema->second));
  }
  return writer_->define(number, channel);
}

absl::Status RecordingOutput::copy(const recording::Item& item, const recording::Definitions& definitions) {
  if (!item.message) return writer_->write(item.extra);
  RETURN_IF_ERROR(define(item.message->channel, definitions));
  return writer_->write(*item.message);
}

absl::Status RecordingOutput::write(const recording::RecordedFrame& frame,
                                    std::optional<std::span<const std::uint32_t>> labels,
                                    const recording::FrameReader& reader) {
  recording::Message message = frame.message;
  message.data = frame.bytes;
  std::string labeled;
  if (labels) {
    ASSIGN_OR_RETURN(labeled, recording::labeled_message(frame, *labels));
    message.data = labeled;
  }
  if (!reader.reads_images()) {
    RETURN_IF_ERROR(define(message.channel, reader.definitions()));
    return writer_->write(message);
  }
  if (!labels) return absl::OkStatus();
  message.channel = reader.free_number();
  RETURN_IF_ERROR(writer_->define(message.channel, recording::point_cloud2_schema()));
  RETURN_IF_ERROR(writer_->define(message.channel, {message.channel, reader.topic().name + "/labeled", "cdr", {}}));
  return writer_->write(message);
}

absl::Status RecordingOutput::finish() {
  RETURN_IF_ERROR(writer_->finish());
  if (file_.get() == stdout) {
    if (std::fflush(stdout) != 0) return cannot_write_recording("-", errno);
    return absl::OkStatus();
  }
  if (std::fclose(file_.release()) != 0) {
    const int error = errno;
    std::error_code ignored;
    if (!temporary_.empty()) fs::remove(temporary_, ignored);
    return cannot_write_recording(path_, error);
  }
  if (temporary_.empty()) return absl::OkStatus();
  std::error_code error;
  fs::rename(temporary_, path_, error);
  return error ? cannot_write_recording(path_, error.value()) : absl::OkStatus();
}

}  // namespace segserve::segctl
