#include "client/segctl/batch.hpp"

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <map>
#include <mutex>
#include <span>
#include <system_error>
#include <thread>
#include <utility>

#include "client/calls/local.hpp"
#include "client/segctl/exit_code.hpp"
#include "client/segctl/input_file.hpp"
#include "client/segctl/progress_bar.hpp"
#include "client/segctl/server_flags.hpp"
#include "client/segctl/staged_output.hpp"
#include "client/segctl/summary.hpp"
#include "fmt/format.h"
#include "nlohmann/json.hpp"
#include "segserve/codec/cloud_file.hpp"

namespace segserve::segctl {
namespace {

using Json = nlohmann::ordered_json;

/// A file that was read, on its way to a result.
struct Scene {
  std::size_t index = 0;
  codec::LabelledCloud scene;
  std::uint64_t bytes = 0;  ///< of the file
};

class Batch {
 public:
  explicit Batch(const BatchJob& job)
      : job_(job),
        key_(batch_key(job.request.options, job.request.view, job.request.codec, job.request.segments)),
        ends_(job.inputs.size()) {
    bar_.emplace("segment");
  }

  void skip_what_is_done();
  void run_here();
  void run_remotely();
  absl::Status report();

 private:
  enum class Kind { kOpen, kSkipped, kSegmented, kFailed };
  struct End {
    Kind kind = Kind::kOpen;
    absl::Status status;
    std::size_t points = 0;
    std::uint32_t segments = 0;
    bool in_this_process = false;
  };

  std::optional<std::size_t> next_open();
  absl::StatusOr<Scene> load(std::size_t index) const;
  absl::Status write(Scene& scene, const client::Result& result) const;
  void end(Scene& scene, const absl::StatusOr<client::Result>& result);
  void note(std::size_t index, End end);
  absl::StatusOr<client::Result> segment_here(const codec::LabelledCloud& scene) const;
  void send_all(client::Stream& stream);
  Json line(std::size_t index) const;

  const BatchJob& job_;
  const std::string key_;
  std::atomic<std::size_t> next_{0};
  std::optional<ProgressBar> bar_;
  mutable std::mutex mutex_;
  std::vector<End> ends_;
  std::size_t ended_ = 0;
  std::map<std::uint64_t, Scene> sent_;  // by the stream's sequence
};

void Batch::note(std::size_t index, End end) {
  const std::lock_guard lock(mutex_);
  ends_[index] = std::move(end);
  bar_->show(++ended_, ends_.size());
}

void Batch::skip_what_is_done() {
  for (std::size_t i = 0; i < job_.inputs.size(); ++i) {
    if (is_done(job_.inputs[i], key_)) note(i, {.kind = Kind::kSkipped, .status = {}});
  }
}

std::optional<std::size_t> Batch::next_open() {
  for (std::size_t i = next_++; i < job_.inputs.size(); i = next_++) {
    const std::lock_guard lock(mutex_);
    if (ends_[i].kind == Kind::kOpen) return i;
  }
  return std::nullopt;
}

absl::StatusOr<Scene> Batch::load(std::size_t index) const {
  const auto bytes = read_input(job_.inputs[index].path);
  if (!bytes.ok()) return bytes.status();
  auto scene = codec::decode_cloud(std::as_bytes(std::span(*bytes)), {}, job_.request.view);
  if (!scene.ok()) return scene.status();
  return Scene{index, *std::move(scene), bytes->size()};
}

absl::Status Batch::write(Scene& scene, const client::Result& result) const {
  const BatchInput& input = job_.inputs[scene.index];
  Json summary = to_json({.result = result,
                          .input = input.path,
                          .server = result.in_this_process ? "" : job_.server,
                          .timings = stage_timings(result),
                          .with_segments = job_.request.segments});
  summary["batch"] = {{"input", input.path}, {"input_bytes", scene.bytes}, {"key", key_}};
  scene.scene.cloud.view = result.view;
  StagedOutput output;
  for (const std::string& path : {input.summary_path, input.cloud_path}) {
    if (absl::Status status = output.announce(path); !status.ok()) return status;
  }
  // Renamed in the opposite order: the summary last.
  output.add(input.summary_path, summary.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
  output.add(input.cloud_path, job_.format->encode_pcd(scene.scene.cloud, result.segmentation.labels));
  return output.commit();
}

void Batch::end(Scene& scene, const absl::StatusOr<client::Result>& result) {
  absl::Status status = result.status();
  if (status.ok()) status = write(scene, *result);
  if (!status.ok()) return note(scene.index, {.kind = Kind::kFailed, .status = status});
  note(scene.index, {Kind::kSegmented, {}, result->points, result->segmentation.segments, result->in_this_process});
}

/// The points as they are, or, if there is a codec, as a server would see them.
absl::StatusOr<client::Result> Batch::segment_here(const codec::LabelledCloud& scene) const {
  const wire::Outputs outputs{.segments = job_.request.segments};
  if (!job_.request.codec) {
    return client::segment_here(scene.cloud, scene.view_rule, job_.request.options, outputs, StopToken());
  }
  const auto payload = client::cloud_payload(scene.cloud, *job_.request.codec);
  if (!payload.ok()) return payload.status();
  auto result = client::segment_here(*payload, job_.request.options, outputs, StopToken());
  if (result.ok()) result->view_rule = scene.view_rule;
  return result;
}

void Batch::run_here() {
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < std::min(job_.parallel, job_.inputs.size()); ++i) {
    threads.emplace_back([this] {
      while (const auto index = next_open()) {
        auto scene = load(*index);
        if (!scene.ok()) {
          note(*index, {.kind = Kind::kFailed, .status = scene.status()});
          continue;
        }
        end(*scene, segment_here(scene->scene));
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
}

void Batch::send_all(client::Stream& stream) {
  std::uint64_t sequence = 0;
  while (const auto index = next_open()) {
    auto scene = load(*index);
    auto payload = scene.ok()
                       ? client::cloud_payload(scene->scene.cloud, job_.request.codec.value_or(wire::CodecOptions{}))
                       : absl::StatusOr<client::Payload>(scene.status());
    if (!payload.ok()) {
      note(*index, {.kind = Kind::kFailed, .status = payload.status()});
      continue;
    }
    {
      const std::lock_guard lock(mutex_);
      sent_.emplace(sequence + 1, *std::move(scene));  // before its outcome can come
    }
    const auto sent = stream.send(*std::move(payload), {.request_id = fmt::format("{}", *index)});
    if (sent.ok()) {
      sequence = *sent;
      continue;
    }
    {
      const std::lock_guard lock(mutex_);
      sent_.erase(sequence + 1);
    }
    note(*index, {.kind = Kind::kFailed, .status = sent.status()});
  }
  stream.finish();
}

void Batch::run_remotely() {
  client::StreamOptions options = job_.stream;
  options.order = client::Order::kDone;
  options.max_in_flight = job_.parallel;
  for (const BatchInput& input : job_.inputs) {
    std::error_code error;
    const std::uintmax_t bytes = std::filesystem::file_size(input.path, error);
    if (!error) options.wanted_bytes = std::max<std::uint64_t>(options.wanted_bytes, 3 * bytes);
  }
  auto stream = job_.client->open_stream(std::move(options));
  if (!stream.ok()) {
    while (const auto index = next_open()) note(*index, {.kind = Kind::kFailed, .status = stream.status()});
    return;
  }
  std::thread sender([&] { send_all(*stream); });
  while (auto outcome = stream->next()) {
    std::unique_lock lock(mutex_);
    Scene scene = std::move(sent_.extract(outcome->sequence).mapped());
    lock.unlock();
    if (outcome->result) {
      outcome->result->view_rule = scene.scene.view_rule;  // the server only knows that it was told
      end(scene, *std::move(outcome->result));
    } else {
      end(scene, outcome->status);
    }
  }
  sender.join();
}

Json Batch::line(std::size_t index) const {
  const End& end = ends_[index];
  Json json{{"input", job_.inputs[index].path}};
  json["state"] = end.kind == Kind::kSegmented ? "segmented" : end.kind == Kind::kSkipped ? "skipped" : "failed";
  json["output"] = end.kind == Kind::kFailed ? Json() : Json(job_.inputs[index].cloud_path);
  json["points"] = end.kind == Kind::kSegmented ? Json(end.points) : Json();
  json["segments"] = end.kind == Kind::kSegmented ? Json(end.segments) : Json();
  json["error"] = end.status.ok() ? Json() : Json(std::string(end.status.message()));
  return json;
}

absl::Status Batch::report() {
  bar_.reset();  // before anything is printed
  if (job_.client && std::ranges::any_of(ends_, &End::in_this_process)) warn_of_fallback(job_.server);
  const auto count = [&](Kind kind) { return std::ranges::count(ends_, kind, &End::kind); };
  StagedOutput output;
  if (!job_.json_path.empty()) {
    std::string lines;
    for (std::size_t i = 0; i < ends_.size(); ++i) {
      lines += line(i).dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
    }
    if (absl::Status status = output.announce(job_.json_path); !status.ok()) return status;
    output.add(job_.json_path, lines);
  }
  if (!job_.quiet && !output.uses_stdout()) {
    output.add("-", fmt::format("{} segmented, {} done before, {} failed\n", count(Kind::kSegmented),
                                count(Kind::kSkipped), count(Kind::kFailed)));
  }
  if (absl::Status status = output.commit(); !status.ok()) return status;
  bool files_fault = true;
  for (std::size_t i = 0; i < ends_.size(); ++i) {
    if (ends_[i].kind != Kind::kFailed) continue;
    print_error(fmt::format("{}: {}", job_.inputs[i].path, std::string(ends_[i].status.message())));
    files_fault = files_fault && exit_code(ends_[i].status) == kBadInput;
  }
  if (count(Kind::kFailed) == 0) return absl::OkStatus();
  const std::string message = fmt::format("{} of {} files failed", count(Kind::kFailed), ends_.size());
  return files_fault ? absl::InvalidArgumentError(message) : absl::UnavailableError(message);
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
