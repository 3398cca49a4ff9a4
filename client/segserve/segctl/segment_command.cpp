#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "fmt/format.h"
#include "segserve/client/result_file.hpp"
#include "segserve/codec/cloud_file.hpp"
#include "segserve/pipeline/segment.hpp"
#include "segserve/segctl/command.hpp"
#include "segserve/segctl/input_file.hpp"
#include "segserve/segctl/local.hpp"
#include "segserve/segctl/option_flags.hpp"
#include "segserve/segctl/scene_output.hpp"
#include "segserve/segctl/server_flags.hpp"
#include "segserve/segctl/staged_output.hpp"
#include "segserve/segctl/summary.hpp"
#include "segserve/segctl/view_flag.hpp"

namespace segserve::segctl {
namespace {

constexpr double kDefaultTimeout = 30;

constexpr const char* kFooter = R"(Examples:
  segctl segment scene.pcd -o labelled.pcd --picture segments.png
  segctl segment scene.ply --view world:0,0,1.5 --server robot:50051 --zstd --json -
  segctl segment scene.pcd --local --method equalization --regions 12 -o - | other-program
  segctl segment scene.pcd --result scene.segres; segctl cut scene.segres --threshold 0.2
  segctl segment scene.pcd --range-max 1.5 --support-plane-distance 0.01 -o objects.pcd

Points that are not finite, that the crop box or the range leaves out, or that are removed with the
support plane get label 0; segments are numbered 1, 2, .. by descending size.
Without --view an organised PCD with the identity VIEWPOINT is seen by the camera, any other PCD
is WORLD with the sensor at VIEWPOINT, and a PLY is WORLD without a sensor.

Exit codes: 0 done; 1 failed (server unreachable, time over, disk full); 2 bad input or usage.)";

struct Arguments {
  std::string scene;
  OptionFlags options;
  std::string view;
  ServerFlags server;
  bool local = false;
  std::string payload = "planar";
  bool zstd = false;
  std::string request_id;
  SceneOutput scene_output;
  std::string result_path;
  std::string json_path;
  bool quiet = false;
};

void add_flags(CLI::App& app, Arguments& arguments) {
  app.add_option("SCENE", arguments.scene, "PCD (ascii, binary, binary_compressed) or PLY file; - is standard input")
      ->required();
  arguments.options.add_to(app);
  app.add_option("--view", arguments.view,
                 "where the sensor is: camera, world, or world:X,Y,Z with its position in metres; "
                 "default: what the file says")
      ->type_name("VIEW")
      ->group("Segmentation");
  arguments.server.add_to(app, kDefaultTimeout);
  app.add_flag("--local", arguments.local, "segment in this process, without a server")->group("Server");
  app.add_option("--payload", arguments.payload, "what is sent: the points as planar raw, or the PCD file as it is")
      ->check(CLI::IsMember({"planar", "pcd"}))
      ->type_name("KIND")
      ->capture_default_str()
      ->group("Server");
  app.add_flag("--zstd", arguments.zstd,
               "compress what is sent, without loss; default: only if it would be too large for one call")
      ->group("Server");
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
  const bool sends_file = arguments.payload == "pcd";
  if (arguments.local && arguments.server.server_given()) {
    return absl::InvalidArgumentError("--local and --server exclude each other");
  }
  if (arguments.local && (sends_file || arguments.zstd || !arguments.request_id.empty())) {
    return absl::InvalidArgumentError("--payload, --zstd and --request-id need a server: not together with --local");
  }
  if (sends_file && arguments.zstd) return absl::InvalidArgumentError("--zstd needs --payload planar");
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

/// Everything that is known before the segmentation: the file, and what is asked of it.
struct Job {
  std::string file_bytes;
  std::optional<codec::LabelledCloud> scene;  ///< unset if nobody but the server needs the points
  std::optional<View> view;                   ///< unset: what the file says
  Options options;
};

absl::StatusOr<codec::LabelledCloud> decode(const Arguments& arguments, const Job& job) {
  auto scene = codec::decode_cloud(std::as_bytes(std::span(job.file_bytes)), {}, job.view);
  if (scene.ok()) return scene;
  return absl::Status(scene.status().code(),
                      fmt::format("{}: {}", input_name(arguments.scene), std::string(scene.status().message())));
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
  if (const auto timeout = arguments.server.timeout(); !timeout.ok()) return timeout.status();
  auto bytes = read_input(arguments.scene);
  if (!bytes.ok()) return bytes.status();
  job.file_bytes = *std::move(bytes);
  return job;
}

absl::StatusOr<client::Result> segment_remotely(const Arguments& arguments, Job& job) {
  const auto client = arguments.server.connect();
  if (!client.ok()) return client.status();
  client::CallOptions call;
  call.request_id = arguments.request_id;
  if (arguments.zstd) {
    call.compress = client::Compress::kAlways;
    call.outputs.compression = v1alpha1::COMPRESSION_ZSTD;
  }
  if (arguments.payload == "pcd") {
    return client->segment_pcd_file(std::move(job.file_bytes), job.view, job.options, call);
  }
  auto result = client->segment(job.scene->cloud, job.options, call);
  if (result.ok()) result->view_rule = job.scene->view_rule;  // the server only knows that it was told
  return result;
}

absl::StatusOr<client::Result> segment_here(const Arguments& arguments, const Job& job) {
  std::optional<StopToken::Clock::time_point> deadline;
  if (arguments.server.timeout_given()) deadline = StopToken::Clock::now() + *arguments.server.timeout();
  return segment_locally(*job.scene, job.options, StopToken(nullptr, deadline));
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
                  .input = input_name(arguments.scene),
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
  if (arguments.payload != "pcd" || arguments.scene_output.wanted()) {
    auto scene = decode(arguments, *job);
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
