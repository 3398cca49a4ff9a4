#include <chrono>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "client/calls/local.hpp"
#include "client/segctl/command.hpp"
#include "client/segctl/input_file.hpp"
#include "client/segctl/segment_arguments.hpp"
#include "client/segctl/segment_many.hpp"
#include "client/segctl/staged_output.hpp"
#include "client/segctl/summary.hpp"
#include "core/codec/ply/ply_header.hpp"
#include "fmt/format.h"
#include "proto/wire/codec_message.hpp"
#include "segserve/client/payload.hpp"
#include "segserve/client/result_file.hpp"
#include "segserve/codec/cloud_file.hpp"
#include "segserve/segment.hpp"

namespace segserve::segctl {
namespace {

absl::Status announce_outputs(const SegmentArguments& arguments, StagedOutput& output) {
  if (absl::Status status = arguments.scene_output.announce(output); !status.ok()) return status;
  for (const std::string& path : {arguments.result_path, arguments.json_path}) {
    if (path.empty()) continue;
    if (absl::Status status = output.announce(path); !status.ok()) return status;
  }
  return absl::OkStatus();
}

/// Everything that is known before the segmentation: the files, and what is asked of them.
struct Job {
  std::string input;                          ///< how the file is called in messages
  std::string file_bytes;                     ///< unset if there is a payload
  std::optional<client::Payload> payload;     ///< what is sent as it is: a PCD file or images
  std::optional<codec::LabelledCloud> scene;  ///< unset if nobody but the server needs the points
  SegmentRequest request;
};

absl::StatusOr<codec::LabelledCloud> decode(const Job& job) {
  auto scene = job.payload ? client::decode(*job.payload)
                           : codec::decode_cloud(std::as_bytes(std::span(job.file_bytes)), {}, job.request.view);
  if (scene.ok()) return scene;
  return absl::Status(scene.status().code(), fmt::format("{}: {}", job.input, std::string(scene.status().message())));
}

absl::Status read_files(const SegmentArguments& arguments, Job& job) {
  if (arguments.rgbd.given()) {
    job.input = arguments.rgbd.input_name();
    auto images = arguments.rgbd.load();
    if (!images.ok()) return images.status();
    job.payload = client::rgbd_payload(*std::move(images));
    return absl::OkStatus();
  }
  job.input = input_name(arguments.scenes.front());
  auto bytes = read_input(arguments.scenes.front());
  if (!bytes.ok()) return bytes.status();
  const bool is_pcd = !codec::is_ply(*bytes);
  if (is_pcd && job.request.codec && job.request.codec->codec == wire::Codec::kPcd) {
    job.payload = client::pcd_payload(*std::move(bytes), job.request.view);
  } else {
    job.file_bytes = *std::move(bytes);
  }
  return absl::OkStatus();
}

absl::StatusOr<Job> prepare(const SegmentArguments& arguments) {
  Job job;
  auto request = arguments.request();
  if (!request.ok()) return request.status();
  job.request = *std::move(request);
  if (job.request.codec && arguments.rgbd.given()) {
    return absl::InvalidArgumentError("--codec, --error-bound and --zstd do not go with RGB-D images");
  }
  if (const auto timeout = arguments.server.timeout(); !timeout.ok()) return timeout.status();
  if (absl::Status status = read_files(arguments, job); !status.ok()) return status;
  return job;
}

absl::StatusOr<client::Result> segment_remotely(const SegmentArguments& arguments, Job& job) {
  const auto client = arguments.server.connect(arguments.fallback_local);
  if (!client.ok()) return client.status();
  client::CallOptions call;
  call.request_id = arguments.request_id;
  call.codec = job.request.codec;
  call.outputs.segments = job.request.segments;
  call.outputs.compression = answer_compression(job.request.codec);
  if (job.payload) return client->segment_payload(*job.payload, job.request.options, call);
  auto result = client->segment(job.scene->cloud, job.request.options, call);
  if (result.ok()) result->view_rule = job.scene->view_rule;  // the server only knows that it was told
  return result;
}

absl::StatusOr<client::Result> segment_here(const SegmentArguments& arguments, const Job& job) {
  std::optional<StopToken::Clock::time_point> deadline;
  if (arguments.server.timeout_given()) deadline = StopToken::Clock::now() + *arguments.server.timeout();
  const StopToken stop(nullptr, deadline);
  const auto segment = [&](const codec::LabelledCloud& scene) {
    return client::segment_here(scene.cloud, scene.view_rule, job.request.options, {.segments = job.request.segments},
                                stop);
  };
  if (!job.request.codec || job.payload) return segment(*job.scene);
  // The points as a server would see them.
  const auto payload = client::cloud_payload(job.scene->cloud, *job.request.codec);
  if (!payload.ok()) return payload.status();
  auto decoded = client::decode(*payload);
  if (!decoded.ok()) return decoded.status();
  decoded->view_rule = job.scene->view_rule;
  return segment(*decoded);
}

absl::Status write_outputs(const SegmentArguments& arguments, Job& job, const client::Result& result, double call_ms,
                           StagedOutput& output) {
  if (arguments.scene_output.wanted()) {
    job.scene->cloud.view = result.view;
    arguments.scene_output.add(output, job.scene->cloud, result.segmentation.labels);
  }
  if (!arguments.result_path.empty()) {
    auto bytes = client::encode_result_file(result);
    if (!bytes.ok()) return bytes.status();
    output.add(arguments.result_path, *std::move(bytes));
  }
  Summary summary{.result = result,
                  .input = job.input,
                  .server = result.in_this_process ? "" : arguments.server.address(),
                  .timings = stage_timings(result),
                  .with_segments = job.request.segments};
  if (!arguments.local) summary.timings.push_back({"round_trip", call_ms});
  return report(summary, arguments.json_path, arguments.quiet, output);
}

double milliseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

absl::Status run(const SegmentArguments& arguments) {
  StagedOutput output;
  if (absl::Status status = arguments.check_combination(); !status.ok()) return status;
  if (!arguments.out_dir.empty()) return segment_many(arguments);
  if (absl::Status status = announce_outputs(arguments, output); !status.ok()) return status;
  auto job = prepare(arguments);
  if (!job.ok()) return job.status();

  auto start = std::chrono::steady_clock::now();
  if (arguments.local || !job->payload || arguments.scene_output.wanted()) {
    auto scene = decode(*job);
    if (!scene.ok()) return scene.status();
    job->scene = *std::move(scene);
  }
  const double decode_ms = milliseconds_since(start);

  start = std::chrono::steady_clock::now();
  auto result = arguments.local ? segment_here(arguments, *job) : segment_remotely(arguments, *job);
  if (!result.ok()) return result.status();
  const double call_ms = milliseconds_since(start);
  if (result->in_this_process && !arguments.local) warn_of_fallback(arguments.server.address());
  if (arguments.local) {
    result->timings.decode = decode_ms;
    result->timings.total += decode_ms;
  }
  return write_outputs(arguments, *job, *result, call_ms, output);
}

}  // namespace

void add_segment_command(CLI::App& app, Command& chosen) {
  CLI::App* command = app.add_subcommand("segment", "Segment a coloured point cloud: one label for every point");
  auto arguments = std::make_shared<SegmentArguments>();
  arguments->add_to(*command);
  command->callback([arguments, &chosen] { chosen = [arguments] { return run(*arguments); }; });
}

}  // namespace segserve::segctl
