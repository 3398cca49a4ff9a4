#include <algorithm>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "fmt/format.h"
#include "segserve/client/payload.hpp"
#include "segserve/client/result_file.hpp"
#include "segserve/codec/cloud_file.hpp"
#include "segserve/codec/ply_header.hpp"
#include "segserve/pipeline/segment.hpp"
#include "segserve/segctl/batch.hpp"
#include "segserve/segctl/codec_flags.hpp"
#include "segserve/segctl/command.hpp"
#include "segserve/segctl/input_file.hpp"
#include "segserve/segctl/local.hpp"
#include "segserve/segctl/option_flags.hpp"
#include "segserve/segctl/rgbd_flags.hpp"
#include "segserve/segctl/scene_output.hpp"
#include "segserve/segctl/server_flags.hpp"
#include "segserve/segctl/staged_output.hpp"
#include "segserve/segctl/summary.hpp"
#include "segserve/segctl/view_flag.hpp"
#include "segserve/wire/codec.hpp"

namespace segserve::segctl {
namespace {

constexpr double kDefaultTimeout = 30;

constexpr const char* kFooter = R"(Examples:
  segctl segment scene.pcd -o labelled.pcd --picture segments.png
  segctl segment scene.ply --view world:0,0,1.5 --server robot:50051 --zstd --json -
  segctl segment scene.pcd --codec quantised --error-bound 0.5
  segctl segment --depth depth.png --rgb color.png --intrinsics 525,525,319.5,239.5 --picture segments.png
  segctl segment scene.pcd --local --method equalization --regions 12 -o - | other-program
  segctl segment scene.pcd --result scene.segres; segctl cut scene.segres --threshold 0.2
  segctl segment scene.pcd --range-max 1.5 --support-plane-distance 0.01 -o objects.pcd
  segctl segment scans/ --out-dir labelled/    # goes on where it was stopped

Points that are not finite, that the crop box or the range leaves out, or that are removed with the
support plane get label 0; segments are numbered 1, 2, .. by descending size.
Without --view an organised PCD with the identity VIEWPOINT is seen by the camera, any other PCD
is WORLD with the sensor at VIEWPOINT, and a PLY is WORLD without a sensor. Images are CAMERA.

Lossy codecs move points by at most their error bound; labels still come back in the order of the input. With --local and a
codec the points are segmented as a server would see them.

With --out-dir a file that fails stops no other; errors are listed at the end, one a line.

Exit codes: 0 done; 1 failed (server unreachable, time over, disk full); 2 bad input or usage. Of many files: 2 if all
that failed were bad input, else 1.)";

struct Arguments {
  std::vector<std::string> scenes;
  std::string scene;  ///< the only one, without --out-dir
  std::string out_dir;
  std::size_t parallel = 0;
  OptionFlags options;
  std::string view;
  ServerFlags server;
  RgbdFlags rgbd;
  CodecFlags codec;
  bool local = false;
  std::string request_id;
  SceneOutput scene_output;
  std::string result_path;
  std::string json_path;
  bool quiet = false;
};

void add_flags(CLI::App& app, Arguments& arguments) {
  app.add_option(
      "SCENE", arguments.scenes,
      "PCD (ascii, binary, binary_compressed) or PLY file; - is standard input; with --out-dir many, or folders");
  arguments.rgbd.add_to(app);
  arguments.options.add_to(app);
  app.add_option("--view", arguments.view,
                 "where the sensor is: camera, world, or world:X,Y,Z with its position in metres; "
                 "default: what the file says")
      ->type_name("VIEW")
      ->group("Segmentation");
  arguments.server.add_to(app, kDefaultTimeout);
  app.add_flag("--local", arguments.local, "segment in this process, without a server")->group("Server");
  arguments.codec.add_to(app,
                         "pcd sends a PCD file as it is; default: planar, and planar-zstd if that would be too large "
                         "for one call",
                         "Server");
  app.add_option("--request-id", arguments.request_id, "name of this call in the server's logs")
      ->type_name("TEXT")
      ->group("Server");
  arguments.scene_output.add_to(app, true);
  app.add_option("--result", arguments.result_path, "save the result with its merge tree, for segctl cut")
      ->type_name("FILE")
      ->group("Output");
  CLI::Option* out_dir =
      app.add_option(
             "--out-dir", arguments.out_dir,
             "for many files: write DIR/NAME.pcd, labelled, and DIR/NAME.json of each, unless they are there and "
             "of the same options")
          ->type_name("DIR")
          ->group("Output");
  app.add_option("--parallel", arguments.parallel, "files at the same time; default 4, with --local one per CPU")
      ->check(CLI::Range(1, 256))
      ->needs(out_dir)
      ->group("Output");
  app.add_option("--json", arguments.json_path,
                 "write the summary as one JSON object, with --out-dir one a file and line; - is standard output")
      ->type_name("FILE")
      ->group("Output");
  app.add_flag("-q,--quiet", arguments.quiet, "print no summary")->group("Output");
}

absl::Status check_combination(const Arguments& arguments) {
  const bool many = !arguments.out_dir.empty();
  if (many && (arguments.scene_output.wanted() || !arguments.result_path.empty() || !arguments.request_id.empty() ||
               arguments.rgbd.given())) {
    return absl::InvalidArgumentError("--out-dir excludes -o, --picture, --result, --request-id and RGB-D images");
  }
  if (!many && arguments.scenes.size() > 1) return absl::InvalidArgumentError("more than one SCENE needs --out-dir");
  if (arguments.scenes.empty() && !arguments.rgbd.given()) {
    return absl::InvalidArgumentError("SCENE is required, or --depth and --intrinsics (see segctl segment --help)");
  }
  if (!arguments.scenes.empty() && arguments.rgbd.given()) {
    return absl::InvalidArgumentError("SCENE and RGB-D images exclude each other");
  }
  if (arguments.rgbd.given() && !arguments.view.empty()) {
    return absl::InvalidArgumentError("--view does not go with RGB-D images: they are seen from the camera");
  }
  if (arguments.local && arguments.server.server_given()) {
    return absl::InvalidArgumentError("--local and --server exclude each other");
  }
  if (arguments.local && !arguments.request_id.empty()) {
    return absl::InvalidArgumentError("--request-id needs a server: not together with --local");
  }
  return absl::OkStatus();
}

absl::Status announce_outputs(const Arguments& arguments, StagedOutput& output) {
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
  std::optional<View> view;                   ///< unset: what the file says
  std::optional<wire::CodecOptions> codec;    ///< unset: as the client library thinks fit
  Options options;
};

absl::StatusOr<codec::LabelledCloud> decode(const Job& job) {
  auto scene = job.payload ? client::decode(*job.payload)
                           : codec::decode_cloud(std::as_bytes(std::span(job.file_bytes)), {}, job.view);
  if (scene.ok()) return scene;
  return absl::Status(scene.status().code(), fmt::format("{}: {}", job.input, std::string(scene.status().message())));
}

absl::Status read_files(const Arguments& arguments, Job& job) {
  if (arguments.rgbd.given()) {
    job.input = arguments.rgbd.input_name();
    auto images = arguments.rgbd.load();
    if (!images.ok()) return images.status();
    job.payload = client::rgbd_payload(*std::move(images));
    return absl::OkStatus();
  }
  job.input = input_name(arguments.scene);
  auto bytes = read_input(arguments.scene);
  if (!bytes.ok()) return bytes.status();
  const bool is_pcd = !codec::is_ply(*bytes);
  if (is_pcd && job.codec && job.codec->codec == wire::Codec::kPcd) {
    job.payload = client::pcd_payload(*std::move(bytes), job.view);
  } else {
    job.file_bytes = *std::move(bytes);
  }
  return absl::OkStatus();
}

absl::StatusOr<std::optional<View>> given_view(const Arguments& arguments) {
  if (arguments.view.empty()) return std::nullopt;
  const auto view = parse_view(arguments.view);
  if (!view.ok()) return view.status();
  return *view;
}

absl::StatusOr<Job> prepare(const Arguments& arguments) {
  Job job;
  auto options = arguments.options.options();
  if (!options.ok()) return options.status();
  job.options = *options;
  const auto view = given_view(arguments);
  if (!view.ok()) return view.status();
  job.view = *view;
  const auto codec = arguments.codec.options();
  if (!codec.ok()) return codec.status();
  job.codec = *codec;
  if (job.codec && arguments.rgbd.given()) {
    return absl::InvalidArgumentError("--codec, --error-bound and --zstd do not go with RGB-D images");
  }
  if (const auto timeout = arguments.server.timeout(); !timeout.ok()) return timeout.status();
  if (absl::Status status = read_files(arguments, job); !status.ok()) return status;
  return job;
}

absl::StatusOr<client::Result> segment_remotely(const Arguments& arguments, Job& job) {
  const auto client = arguments.server.connect();
  if (!client.ok()) return client.status();
  client::CallOptions call;
  call.request_id = arguments.request_id;
  call.codec = job.codec;
  call.outputs.compression = answer_compression(job.codec);
  if (job.payload) return client->segment_payload(*job.payload, job.options, call);
  auto result = client->segment(job.scene->cloud, job.options, call);
  if (result.ok()) result->view_rule = job.scene->view_rule;  // the server only knows that it was told
  return result;
}

absl::StatusOr<client::Result> segment_here(const Arguments& arguments, const Job& job) {
  std::optional<StopToken::Clock::time_point> deadline;
  if (arguments.server.timeout_given()) deadline = StopToken::Clock::now() + *arguments.server.timeout();
  const StopToken stop(nullptr, deadline);
  if (!job.codec || job.payload) return segment_locally(*job.scene, job.options, stop);
  // The points as a server would see them.
  const auto payload = client::cloud_payload(job.scene->cloud, *job.codec);
  if (!payload.ok()) return payload.status();
  auto decoded = client::decode(*payload);
  if (!decoded.ok()) return decoded.status();
  decoded->view_rule = job.scene->view_rule;
  return segment_locally(*decoded, job.options, stop);
}

absl::Status write_outputs(const Arguments& arguments, Job& job, const client::Result& result, double call_ms,
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
                  .server = arguments.local ? "" : arguments.server.address(),
                  .timings = stage_timings(result)};
  if (!arguments.local) summary.timings.push_back({"round_trip", call_ms});
  return report(summary, arguments.json_path, arguments.quiet, output);
}

double milliseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

absl::Status prepare_remote(const Arguments& arguments, BatchJob& job) {
  auto client = arguments.server.connect();
  if (!client.ok()) return client.status();
  // Before a run in which every file would fail for the same reason.
  if (const auto info = client->server_info(); !info.ok()) return info.status();
  job.client = *std::move(client);
  job.server = arguments.server.address();
  job.stream.client_name = "segctl segment";
  job.stream.options = job.options;
  job.stream.outputs = {.labels = true};
  job.stream.outputs.compression = answer_compression(job.codec);
  job.stream.frame_timeout = *arguments.server.timeout();
  return absl::OkStatus();
}

absl::Status run_many(const Arguments& arguments) {
  BatchJob job;
  const auto options = arguments.options.options();
  if (!options.ok()) return options.status();
  job.options = *options;
  const auto view = given_view(arguments);
  if (!view.ok()) return view.status();
  job.view = *view;
  const auto codec = arguments.codec.options();
  if (!codec.ok()) return codec.status();
  job.codec = *codec;
  std::error_code error;
  if (!std::filesystem::is_directory(arguments.out_dir, error)) {
    return absl::InvalidArgumentError(fmt::format("--out-dir: there is no folder {}", arguments.out_dir));
  }
  auto inputs = batch_inputs(arguments.scenes, arguments.out_dir);
  if (!inputs.ok()) return inputs.status();
  job.inputs = *std::move(inputs);
  const std::size_t usual = arguments.local ? std::max(1U, std::thread::hardware_concurrency()) : 4;
  job.parallel = arguments.parallel == 0 ? usual : arguments.parallel;
  job.format = &arguments.scene_output;
  job.json_path = arguments.json_path;
  job.quiet = arguments.quiet;
  if (!arguments.local) {
    if (absl::Status status = prepare_remote(arguments, job); !status.ok()) return status;
  }
  return run_batch(job);
}

absl::Status run(Arguments& arguments) {
  StagedOutput output;
  if (absl::Status status = check_combination(arguments); !status.ok()) return status;
  if (!arguments.out_dir.empty()) return run_many(arguments);
  if (!arguments.scenes.empty()) arguments.scene = arguments.scenes.front();
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
  if (arguments.local) {
    result->timings.decode = decode_ms;
    result->timings.total += decode_ms;
  }
  return write_outputs(arguments, *job, *result, call_ms, output);
}

}  // namespace

void add_segment_command(CLI::App& app, Command& chosen) {
  CLI::App* command = app.add_subcommand("segment", "Segment a coloured point cloud: one label for every point");
  auto arguments = std::make_shared<Arguments>();
  add_flags(*command, *arguments);
  command->footer(kFooter);
  command->callback([arguments, &chosen] { chosen = [arguments] { return run(*arguments); }; });
}

}  // namespace segserve::segctl
