// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/eval_tracks.hpp"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include "client/segctl/json_flag.hpp"
#include "client/segctl/progress_bar.hpp"
#include "client/segctl/sequence.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "core/lab/eval/contingency.hpp"
#include "core/lab/eval/evaluation.hpp"
#include "fmt/format.h"
#include "nlohmann/json.hpp"
#include "segserve/segment.hpp"

namespace segserve::segctl {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Objects of which fewer points can be seen are not scored.
constexpr std::uint64_t kLeastPoints = 100;

double milliseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

/// Follows a sequence through its frames.
class SequenceScoring {
 public:
  SequenceScoring(const TrackEvaluation& evaluation, std::string name)
      : evaluation_(evaluation),
        scoring_(kLeastPoints),
        cut_scoring_(kLeastPoints),
        result_{.name = std::move(name), .scores = {}} {}

  absl::Status add(const fs::path& path, const SequenceFrame& frame) {
    ASSIGN_OR_RETURN(const codec::LabeledCloud scene,
                     eval::load_scene(path, evaluation_.degradation, evaluation_.read));
    auto start = std::chrono::steady_clock::now();
    ASSIGN_OR_RETURN(const Segmentation segmentation, segmenter_.segment(scene.cloud, evaluation_.options));
    result_.segment_ms += milliseconds_since(start);
    TrackOptions options = evaluation_.flags->options;
    options.time = frame.time;
    if (!evaluation_.flags->no_poses) options.pose = frame.pose;
    start = std::chrono::steady_clock::now();
    ASSIGN_OR_RETURN(const Tracking tracking, track(segmentation, scene.cloud.view, state_, options));
    const double ms = milliseconds_since(start);
    result_.track_ms += ms;
    result_.slowest_track_ms = std::max(result_.slowest_track_ms, ms);
    // The state goes through its bytes, as it would between servers.
    const std::string bytes = tracking.state.bytes();
    result_.state_bytes = std::max(result_.state_bytes, bytes.size());
    ASSIGN_OR_RETURN(state_, TrackState::parse(bytes));
    ASSIGN_OR_RETURN(std::vector<std::uint32_t> labels, label_points(segmentation.supervoxels, tracking.cut));
    for (std::uint32_t& label : labels) {
      label = label == 0 ? 0 : static_cast<std::uint32_t>(tracking.track_of_segment[label - 1]);
    }
    ASSIGN_OR_RETURN(const eval::Contingency table, eval::tabulate(scene.label, labels));
    scoring_.add(table);
    ASSIGN_OR_RETURN(const eval::Contingency cut_table, eval::tabulate(scene.label, segmentation.labels));
    cut_scoring_.add(cut_table);
    return absl::OkStatus();
  }

  SequenceScores finish() {
    result_.scores = scoring_.scores();
    result_.cut_deta = cut_scoring_.scores().deta;
    const auto frames = static_cast<double>(std::max<std::uint64_t>(1, result_.scores.frames));
    result_.segment_ms /= frames, result_.track_ms /= frames;
    return std::move(result_);
  }

 private:
  const TrackEvaluation& evaluation_;
  Segmenter segmenter_;
  TrackState state_;
  eval::TrackScoring scoring_, cut_scoring_;
  SequenceScores result_;
};

/// The folder itself if it has clouds, or else the folders in it, sorted by name.
std::vector<fs::path> sequence_folders(const fs::path& folder) {
  std::vector<fs::path> folders;
  std::error_code error;
  if (eval::scene_files(folder).ok()) return {folder};
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    if (entry->is_directory(error)) folders.push_back(entry->path());
  }
  std::ranges::sort(folders);
  return folders.empty() ? std::vector<fs::path>{folder} : folders;
}

Json scores_json(const eval::TrackScores& s) {
  return {{"frames", s.frames},
          {"objects", s.objects},
          {"tracks", s.tracks},
          {"hota", s.hota},
          {"deta", s.deta},
          {"assa", s.assa},
          {"hota50", s.hota50},
          {"idf1", s.idf1},
          {"switches", s.switches},
          {"switches_per_100_frames", s.switches_per_100_frames()},
          {"visible_switches", s.visible_switches},
          {"visible_switches_per_100_frames", s.visible_switches_per_100_frames()}};
}

template <typename Value>
double mean(const TrackReport& report, Value value) {
  double sum = 0;
  for (const SequenceScores& sequence : report.sequences) sum += value(sequence);
  return sum / static_cast<double>(report.sequences.size());
}

}  // namespace

absl::StatusOr<TrackReport> score_tracks(const TrackEvaluation& evaluation) {
  RETURN_IF_ERROR(evaluation.flags->check());
  RETURN_IF_ERROR(eval::check(evaluation.degradation));
  TrackReport report{.folder = evaluation.folder, .sequences = {}};
  for (const fs::path& folder : sequence_folders(evaluation.folder)) {
    ASSIGN_OR_RETURN(const Sequence sequence,
                     read_sequence(folder.string(), evaluation.flags->rate, codec::ReadableFor::kLabels));
    const std::vector<SequenceFrame>& frames = sequence.frames;
    SequenceScoring scoring(evaluation, folder.filename().string());
    const ProgressBar bar("scoring");
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const fs::path path = folder / frames[i].file;
      const absl::Status status = scoring.add(path, frames[i]);
      if (!status.ok()) {
        return message_of(status).starts_with(path.string()) ? status : with_prefix(path.string(), status);
      }
      bar.show(i + 1, frames.size());
    }
    report.sequences.push_back(scoring.finish());
  }
  return report;
}

std::string to_json(const TrackReport& report) {
  Json json{{"data", report.folder}, {"sequences", Json::array()}};
  for (const SequenceScores& sequence : report.sequences) {
    Json item{{"name", sequence.name}};
    item.update(scores_json(sequence.scores));
    item["cut_deta"] = sequence.cut_deta;
    item["segment_ms"] = sequence.segment_ms;
    item["track_ms"] = sequence.track_ms;
    item["slowest_track_ms"] = sequence.slowest_track_ms;
    item["state_bytes"] = sequence.state_bytes;
    json["sequences"].push_back(std::move(item));
  }
  json["mean"] = {
      {"hota", mean(report, [](const auto& s) { return s.scores.hota; })},
      {"idf1", mean(report, [](const auto& s) { return s.scores.idf1; })},
      {"switches_per_100_frames", mean(report, [](const auto& s) { return s.scores.switches_per_100_frames(); })},
      {"visible_switches_per_100_frames",
       mean(report, [](const auto& s) { return s.scores.visible_switches_per_100_frames(); })},
      {"track_ms", mean(report, [](const auto& s) { return s.track_ms; })}};
  return json_text(json);
}

std::string to_text(const TrackReport& report) {
  std::string text =
      fmt::format("{:<16} {:>6} {:>6} {:>6} {:>6} {:>6} {:>8} {:>7} {:>7} {:>9} {:>9} {:>8}\n", "sequence", "frames",
                  "HOTA", "DetA", "AssA", "IDF1", "cut DetA", "objects", "tracks", "switches", "visible", "track ms");
  for (const SequenceScores& sequence : report.sequences) {
    const eval::TrackScores& s = sequence.scores;
    text += fmt::format("{:<16} {:>6} {:>6.3f} {:>6.3f} {:>6.3f} {:>6.3f} {:>8.3f} {:>7} {:>7} {:>9} {:>9} {:>8.2f}\n",
                        sequence.name, s.frames, s.hota, s.deta, s.assa, s.idf1, sequence.cut_deta, s.objects, s.tracks,
                        s.switches, s.visible_switches, sequence.track_ms);
  }
  text += fmt::format("mean: HOTA {:.3f}, IDF1 {:.3f}, id switches in 100 frames {:.2f}, of objects in sight {:.2f}\n",
                      mean(report, [](const auto& s) { return s.scores.hota; }),
                      mean(report, [](const auto& s) { return s.scores.idf1; }),
                      mean(report, [](const auto& s) { return s.scores.switches_per_100_frames(); }),
                      mean(report, [](const auto& s) { return s.scores.visible_switches_per_100_frames(); }));
  return text;
}

}  // namespace segserve::segctl
