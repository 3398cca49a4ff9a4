// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/segment_recording.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "client/recording/topic/frame_reader.hpp"
#include "client/segctl/frame_segmentation.hpp"
#include "client/segctl/messages.hpp"
#include "client/segctl/output_folder.hpp"
#include "client/segctl/progress_bar.hpp"
#include "client/segctl/recording_output.hpp"
#include "client/segctl/recording_report.hpp"
#include "client/segctl/staged_output.hpp"
#include "core/base/status_macros.hpp"
#include "fmt/format.h"

namespace segserve::segctl {
namespace {

namespace fs = std::filesystem;

absl::Status check_flags(const SegmentArguments& arguments) {
  RETURN_IF_ERROR(arguments.track.check());
  const SceneOutput& output = arguments.scene_output;
  if (output.wants_picture() || arguments.dendrogram.given() || !arguments.contact_sheet.empty() ||
      !arguments.result_path.empty() || !arguments.request_id.empty()) {
    return absl::InvalidArgumentError(
        "--picture, --plain-picture, --dendrogram, --contact-sheet, --result and --request-id are not for a recording");
  }
  RETURN_IF_ERROR(output.check_without_pictures());
  const std::string& path = output.cloud_path();
  if (path.empty()) return absl::OkStatus();
  if (path != "-" && fs::path(path).extension() != ".mcap") {
    return absl::InvalidArgumentError(
        fmt::format("-o {}: of a recording the name must end in .mcap; --out-dir writes a PCD file a frame", path));
  }
  if (!output.format_key().empty()) {
    return absl::InvalidArgumentError("--encoding, --color and --drop-unlabeled do not go with a recording as output");
  }
  return absl::OkStatus();
}

/// The frames of a recording on their way from the file to the outputs.
class RecordingRun {
 public:
  explicit RecordingRun(const SegmentArguments& arguments) : arguments_(arguments), input_(arguments.scenes.front()) {}

  absl::Status run();

 private:
  absl::Status open();
  absl::Status segment_all();
  /// Writes the oldest frame that waits.
  absl::Status complete_one();
  absl::Status write(SegmentedFrame& done);
  absl::Status write_file(const SegmentedFrame& done) const;
  absl::Status finish_output();
  absl::Status report();

  const SegmentArguments& arguments_;
  const std::string input_;
  StagedOutput staged_;
  std::optional<recording::FrameReader> reader_;
  std::optional<FrameSegmentation> segmentation_;
  std::optional<RecordingOutput> output_;
  std::optional<RecordingReport> report_;
};

absl::Status RecordingRun::open() {
  const std::string& path = arguments_.scene_output.cloud_path();
  RETURN_IF_ERROR(staged_.protect(arguments_.scenes));
  if (!path.empty()) RETURN_IF_ERROR(staged_.announce_labeled_cloud(path));  // It holds all that the recording does.
  RETURN_IF_ERROR(arguments_.json.announce(staged_));
  ASSIGN_OR_RETURN(const SegmentRequest request, arguments_.request());
  client::TopicReaderOptions options;
  options.topic = arguments_.recording.topic;
  options.color_topic = arguments_.recording.color_topic;
  options.camera_info_topic = arguments_.recording.camera_info_topic;
  options.view = request.view;
  options.unit = request.unit.value_or(codec::LengthUnit::kMeter);
  options.keep_everything = !arguments_.out_dir.empty();
  ASSIGN_OR_RETURN(reader_, recording::FrameReader::open(input_, options, {}));
  report_.emplace(input_, reader_->topic(), arguments_.local ? "" : arguments_.server.address(),
                  RecordingReport::Json{arguments_.json.given(), request.segments});
  ASSIGN_OR_RETURN(segmentation_, FrameSegmentation::start(arguments_));
  if (!arguments_.out_dir.empty()) RETURN_IF_ERROR(make_folder(arguments_.out_dir));
  if (path.empty()) return absl::OkStatus();
  ASSIGN_OR_RETURN(RecordingOutput output, RecordingOutput::create(path, reader_->profile()));
  output_.emplace(std::move(output));
  return absl::OkStatus();
}

absl::Status RecordingRun::segment_all() {
  const ProgressBar bar("segment");
  const auto copy = [this](const recording::Item& item) { return output_->copy(item, reader_->definitions()); };
  const bool copies = output_ && !arguments_.recording.only_topic;
  while (true) {
    ASSIGN_OR_RETURN(auto frame, reader_->next(copies ? copy : recording::FrameReader::OnOther(), {}));
    if (!frame) break;
    if (!segmentation_->has_room()) RETURN_IF_ERROR(complete_one());
    segmentation_->add(*std::move(frame));
    bar.show(report_->frames(), reader_->topic().messages);
  }
  while (!segmentation_->is_empty()) RETURN_IF_ERROR(complete_one());
  return absl::OkStatus();
}

absl::Status RecordingRun::complete_one() {
  SegmentedFrame done = segmentation_->next();
  // Every other frame would fail, too.
  if (absl::IsUnavailable(done.result.status())) return done.result.status();
  RETURN_IF_ERROR(write(done));
  report_->add(done.recorded.frame, done.result);
  return absl::OkStatus();
}

absl::Status RecordingRun::write(SegmentedFrame& done) {
  if (!arguments_.out_dir.empty() && done.result.ok()) RETURN_IF_ERROR(write_file(done));
  if (!output_) return absl::OkStatus();
  if (done.result.ok()) {
    absl::Status written = output_->write(done.recorded, shown_labels(*done.result), *reader_);
    if (!absl::IsInvalidArgument(written)) return written;
    done.result = written;  // There is no room for labels.
  }
  return output_->write(done.recorded, std::nullopt, *reader_);
}

absl::Status RecordingRun::write_file(const SegmentedFrame& done) const {
  const std::string name = fmt::format("{}-{:06}.pcd", fs::path(input_).stem().string(), done.recorded.frame.index);
  const std::string path = (fs::path(arguments_.out_dir) / name).string();
  StagedOutput output;
  RETURN_IF_ERROR(output.announce(path));
  output.add(path, arguments_.scene_output.encode_pcd(*done.recorded.frame.content, shown_labels(*done.result)).bytes);
  return output.commit();
}

absl::Status RecordingRun::finish_output() {
  if (!output_) return absl::OkStatus();
  for (const auto& [number, channel] : reader_->definitions().channels) {
    const bool is_kept =
        !arguments_.recording.only_topic || (channel.topic == reader_->topic().name && !reader_->reads_images());
    if (is_kept) RETURN_IF_ERROR(output_->define(number, reader_->definitions()));
  }
  return output_->finish();
}

absl::Status RecordingRun::report() {
  const std::vector<codec::Warning>& warnings = reader_->warnings();
  arguments_.json.add(staged_, report_->json_lines(warnings));
  if (report_->in_this_process() && !arguments_.local) warn_of_fallback(arguments_.server.address());
  for (const codec::Warning& warning : warnings) print_warning(fmt::format("{}: {}", input_, warning.message));
  if (!arguments_.quiet && !staged_.uses_stdout()) {
    staged_.add("-", report_->text());
  } else if (!arguments_.quiet && !arguments_.json.given()) {
    report_->print_warnings_of_frames();
  }
  RETURN_IF_ERROR(staged_.commit());
  return report_->status(warnings);
}

absl::Status RecordingRun::run() {
  RETURN_IF_ERROR(open());
  RETURN_IF_ERROR(segment_all());
  RETURN_IF_ERROR(finish_output());
  return report();
}

}  // namespace

absl::Status segment_recording(const SegmentArguments& arguments) {
  RETURN_IF_ERROR(check_flags(arguments));
  return RecordingRun(arguments).run();
}

}  // namespace segserve::segctl
