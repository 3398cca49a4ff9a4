// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/batch.hpp"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <span>
#include <system_error>
#include <thread>
#include <utility>

#include "client/calls/local.hpp"
#include "client/segctl/batch_progress.hpp"
#include "client/segctl/batch_report.hpp"
#include "client/segctl/input_file.hpp"
#include "client/segctl/interrupt.hpp"
#include "client/segctl/summary.hpp"
#include "core/base/mutex.hpp"
#include "core/base/status_macros.hpp"
#include "fmt/format.h"
#include "nlohmann/json.hpp"
#include "proto/text/view_text.hpp"
#include "proto/wire/codec_message.hpp"
#include "proto/wire/options_message.hpp"
#include "segserve/codec/cloud_file.hpp"

namespace segserve::segctl {
namespace {

/// A file that was read and waits for its result.
struct Scene {
  std::size_t file = 0;  ///< Index of the input.
  codec::LabeledCloud content;
  std::uint64_t bytes = 0;  ///< Size of the file.
};

/// The scenes that were sent and have no result yet, by the sequence number of their frame.
class SentScenes {
 public:
  void put(std::uint64_t sequence, Scene scene) ABSL_LOCKS_EXCLUDED(mutex_) {
    const MutexLock lock(mutex_);
    scenes_.emplace(sequence, std::move(scene));
  }
  Scene take(std::uint64_t sequence) ABSL_LOCKS_EXCLUDED(mutex_) {
    const MutexLock lock(mutex_);
    return std::move(scenes_.extract(sequence).mapped());
  }
  std::vector<std::uint64_t> sequences() ABSL_LOCKS_EXCLUDED(mutex_) {
    const MutexLock lock(mutex_);
    std::vector<std::uint64_t> sequences;
    sequences.reserve(scenes_.size());
    for (const auto& [sequence, scene] : scenes_) sequences.push_back(sequence);
    return sequences;
  }

 private:
  Mutex mutex_;
  std::map<std::uint64_t, Scene> scenes_ ABSL_GUARDED_BY(mutex_);
};

/// Names everything that decides an output besides the points of its file: a hash of all options, the view if one was
/// given, a lossy codec, whether statistics are told, and the format of the cloud.
std::string batch_key(const SegmentRequest& request, const SceneOutput& format) {
  std::string key = fmt::format("{} {}", wire::options_hash(request.options),
                                request.view ? text::view_text(*request.view) : "as the file says");
  if (request.codec && !wire::info(request.codec->codec).is_lossless) {
    key += fmt::format(" {} {} {}", wire::info(request.codec->codec).name, request.codec->error_bound,
                       request.codec->jpeg_quality);
  }
  if (request.unit) key += fmt::format(" {}", name(*request.unit));
  if (request.segments) key += " segments";
  return key + format.format_key();
}

class Batch {
 public:
  explicit Batch(const BatchJob& job)
      : job_(job), key_(batch_key(job.request, *job.format)), progress_(job.inputs.size()) {}

  void skip_what_is_done();
  void run_here();
  void run_remotely();
  absl::Status report() { return report_batch(job_, progress_.finish(), progress_.stopped()); }

 private:
  absl::StatusOr<Scene> load(std::size_t file) const;
  absl::StatusOr<client::Result> segment_here(const codec::LabeledCloud& content) const;
  absl::Status write(Scene& scene, client::Result& result) const;
  /// Writes the outputs of a result and records the outcome.
  void complete(Scene scene, absl::StatusOr<client::Result> result);
  /// Records why a file has no result, unless that is why the batch stops.
  void fail(std::size_t file, const absl::Status& status);
  /// Stops the batch if a signal has come; returns whether it has.
  bool is_interrupted();

  client::StreamOptions stream_options() const;
  void send_all(client::Stream& stream);
  /// Loads a file and sends it as the frame `sequence`.
  absl::Status send(std::size_t file, std::uint64_t sequence, client::Stream& stream);
  void receive(client::Outcome outcome);

  const Interrupt interrupt_;
  const BatchJob& job_;
  const std::string key_;
  BatchProgress progress_;
  SentScenes sent_;
};

void Batch::skip_what_is_done() {
  for (std::size_t file = 0; file < job_.inputs.size(); ++file) {
    if (const auto done = done_before(job_.inputs[file], key_)) {
      progress_.record(file, {FileOutcome::State::kSkipped, done->points, done->segments, false, {}});
    }
  }
}

absl::StatusOr<Scene> Batch::load(std::size_t file) const {
  ASSIGN_OR_RETURN(const std::string bytes, read_input(job_.inputs[file].path));
  ASSIGN_OR_RETURN(auto content, codec::decode_cloud(std::as_bytes(std::span(bytes)), {}, job_.request.read_options()));
  return Scene{file, std::move(content), bytes.size()};
}

absl::Status Batch::write(Scene& scene, client::Result& result) const {
  const BatchInput& input = job_.inputs[scene.file];
  if (job_.sheet != nullptr) job_.sheet->add(scene.file, scene.content.cloud, result.segmentation.labels);
  if (input.cloud_path.empty()) return absl::OkStatus();
  codec::EncodedFile cloud = job_.format->encode_pcd(scene.content, result.segmentation.labels);
  append_warnings(input.cloud_path, cloud.warnings, result.warnings);
  auto summary = to_json({.result = result,
                          .input = input.path,
                          .server = result.in_this_process ? "" : job_.server,
                          .timings = stage_timings(result),
                          .with_segments = job_.request.segments});
  summary["batch"] = {{"input", input.path}, {"input_bytes", scene.bytes}, {"key", key_}};
  StagedOutput output;
  for (const std::string& path : {input.summary_path, input.cloud_path}) RETURN_IF_ERROR(output.announce(path));
  // Files are renamed in the opposite order, the summary last.
  output.add(input.summary_path, json_text(summary));
  output.add(input.cloud_path, std::move(cloud.bytes));
  return output.commit();
}

bool Batch::is_interrupted() {
  if (interrupt_.came()) progress_.stop(absl::CancelledError());
  return interrupt_.came();
}

void Batch::fail(std::size_t file, const absl::Status& status) {
  if (client::is_outage(status)) return progress_.stop(status);
  if (!absl::IsCancelled(status) || !is_interrupted()) progress_.record_failure(file, status);
}

void Batch::complete(Scene scene, absl::StatusOr<client::Result> result) {
  const absl::Status status = result.ok() ? write(scene, *result) : result.status();
  if (!status.ok()) return fail(scene.file, status);
  progress_.record(scene.file, {FileOutcome::State::kSegmented,
                                result->points,
                                result->segmentation.segments,
                                result->in_this_process,
                                {},
                                result->warnings});
}

/// Segments the points as they are or, with a codec, as a server would see them.
absl::StatusOr<client::Result> Batch::segment_here(const codec::LabeledCloud& content) const {
  const wire::Outputs outputs{.segments = job_.request.segments};
  const Options options = codec::to_cloud(content.placement, job_.request.options);
  const StopToken stop(&interrupt_.flag());
  if (!job_.request.codec) {
    ASSIGN_OR_RETURN(auto result, client::segment_here(content.cloud, content.view_rule, options, outputs, stop));
    take_file_facts(content, result);
    return result;
  }
  ASSIGN_OR_RETURN(const auto payload, client::cloud_payload(content.cloud, *job_.request.codec));
  ASSIGN_OR_RETURN(auto result, client::segment_here(payload, options, outputs, stop));
  take_file_facts(content, result);
  return result;
}

void Batch::run_here() {
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < std::min(job_.parallel, job_.inputs.size()); ++i) {
    threads.emplace_back([this] {
      while (!is_interrupted()) {
        const auto file = progress_.take_next();
        if (!file) return;
        auto scene = load(*file);
        if (!scene.ok()) {
          fail(*file, scene.status());
          continue;
        }
        auto result = segment_here(scene->content);
        complete(*std::move(scene), std::move(result));
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
}

absl::Status Batch::send(std::size_t file, std::uint64_t sequence, client::Stream& stream) {
  ASSIGN_OR_RETURN(Scene scene, load(file));
  ASSIGN_OR_RETURN(auto payload,
                   client::cloud_payload(scene.content.cloud, job_.request.codec.value_or(wire::CodecOptions{})));
  const codec::Placement placement = scene.content.placement;
  sent_.put(sequence, std::move(scene));  // The outcome can come before send returns.
  client::FrameOptions frame{.request_id = fmt::format("{}", file), .traceparent = job_.request.traceparent};
  if (!placement.is_identity()) frame.options = codec::to_cloud(placement, job_.request.options);
  const auto sent = stream.send(std::move(payload), frame);
  if (!sent.ok()) sent_.take(sequence);
  return sent.status();
}

void Batch::send_all(client::Stream& stream) {
  std::uint64_t sequence = 1;  // The stream numbers its frames from 1, and does not count those that it refused.
  while (const auto file = progress_.take_next()) {
    const absl::Status status = send(*file, sequence, stream);
    if (status.ok()) {
      ++sequence;
    } else {
      fail(*file, status);
    }
  }
  stream.finish();
}

client::StreamOptions Batch::stream_options() const {
  client::StreamOptions options = job_.stream;
  options.order = client::Order::kDone;
  options.max_in_flight = job_.parallel;
  for (const BatchInput& input : job_.inputs) {
    std::error_code error;
    const std::uintmax_t bytes = std::filesystem::file_size(input.path, error);
    constexpr std::uint64_t kMostGrowth = 3;  // A compressed file is larger once it is decoded.
    if (!error) options.wanted_bytes = std::max<std::uint64_t>(options.wanted_bytes, kMostGrowth * bytes);
  }
  return options;
}

void Batch::run_remotely() {
  auto stream = job_.client->open_stream(stream_options());
  if (!stream.ok()) {
    while (const auto file = progress_.take_next()) progress_.record_failure(*file, stream.status());
    return;
  }
  std::thread sender([&] { send_all(*stream); });
  constexpr std::chrono::milliseconds kPatience{100};  // until it looks whether a signal has come
  while (!stream->done()) {
    if (auto outcome = stream->next(kPatience)) receive(*std::move(outcome));
    if (is_interrupted()) std::ranges::for_each(sent_.sequences(), [&](auto frame) { stream->cancel(frame); });
  }
  sender.join();
}

void Batch::receive(client::Outcome outcome) {
  Scene scene = sent_.take(outcome.sequence);
  if (!outcome.result) return fail(scene.file, outcome.status);
  take_file_facts(scene.content, *outcome.result);
  complete(std::move(scene), *std::move(outcome.result));
}

}  // namespace

absl::Status run_batch(const BatchJob& job) {
  Batch batch(job);
  batch.skip_what_is_done();
  if (job.client) {
    batch.run_remotely();
  } else {
    batch.run_here();
  }
  return batch.report();
}

}  // namespace segserve::segctl
