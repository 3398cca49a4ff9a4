#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "fmt/format.h"
#include "segserve/client/payload.hpp"
#include "segserve/client/result_file.hpp"
#include "segserve/codec/cloud_file.hpp"
#include "segserve/codec/ply_header.hpp"
#include "segserve/pipeline/segment.hpp"
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

Points that are not finite, that the crop box or the range leaves out, or that are removed with the
support plane get label 0; segments are numbered 1, 2, .. by descending size.
Without --view an organised PCD with the identity VIEWPOINT is seen by the camera, any other PCD
is WORLD with the sensor at VIEWPOINT, and a PLY is WORLD without a sensor. Images are CAMERA.

Lossy codecs move points by at most their error bound; labels still come back in the order of the input. With --local and a
codec the points are segmented as a server would see them.

Exit codes: 0 done; 1 failed (server unreachable, time over, disk full); 2 bad input or usage.)";

struct Arguments {
  std::string scene;
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
  app.add_option("SCENE", arguments.scene, "PCD (ascii, binary, binary_compressed) or PLY file; - is standard input");
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
  app.add_option("--json", arguments.json_path, "write the summary as one JSON object; - is standard output")
      ->type_name("FILE")
      ->group("Output");
  app.add_flag("-q,--quiet", arguments.quiet, "print no summary")->group("Output");
}

absl::Status check_combination(const Arguments& arguments) {
  if (arguments.scene.empty() && !arguments.rgbd.given()) {
    return absl::InvalidArgumentError("SCENE is required, or --depth and --intrinsics (see segctl segment --help)");
  }
  if (!arguments.scene.empty() && arguments.rgbd.given()) {
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

absl::StatusOr<Job> prepare(const Arguments& arguments) {
  Job job;
  auto options = arguments.options.options();
  if (!options.ok()) return options.status();
  job.options = *options;
  if (!arguments.view.empty()) {
    const auto view = parse_view(arguments.view);
    if (!view.ok()) return view.status();
    job.view = *view;
  }
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

absl::Status run(const Arguments& arguments) {
  StagedOutput output;
  if (absl::Status status = check_combination(arguments); !status.ok()) return status;
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
