// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "client/load_test/arrivals.hpp"
#include "client/load_test/load.hpp"
#include "client/load_test/load_report.hpp"
#include "client/load_test/objective.hpp"
#include "client/segctl/bench_recording.hpp"
#include "client/segctl/bench_summary.hpp"
#include "client/segctl/codec_flags.hpp"
#include "client/segctl/command.hpp"
#include "client/segctl/input_file.hpp"
#include "client/segctl/json_flag.hpp"
#include "client/segctl/option_flags.hpp"
#include "client/segctl/progress_bar.hpp"
#include "client/segctl/recording_flags.hpp"
#include "client/segctl/server_flags.hpp"
#include "client/segctl/staged_output.hpp"
#include "command_line/not_negative.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "core/lab/synth/scene.hpp"
#include "fmt/format.h"
#include "nlohmann/json.hpp"
#include "proto/wire/codec_message.hpp"
#include "segserve/codec/cloud_file.hpp"
#include "segserve/v1/segmentation_service.pb.h"

namespace segserve::segctl {
namespace {

constexpr double kDefaultTimeout = 30;
constexpr std::size_t kOpenLoopInFlight = 8;
constexpr std::size_t kOpenLoopWaiting = 1024;  // An open loop must not wait until the stream takes a frame.

constexpr const char* kDetails =
    R"(Without --rate the loop is closed: every client sends a frame as soon as it has fewer than --in-flight unanswered ones.
With it the loop is open: frames are due at fixed or random times, whatever became of earlier frames. Latency counts
from the time at which a frame was due until its result is decoded, so that a server that stalls does not hide the
frames that it held up. "since sent" counts from the time at which the frame was handed over.

A recording is an open loop, too: every client replays it over and over, with the times at which its frames were
recorded. Clients begin at different frames. --speed 0 makes it a closed loop.

Objectives are METRIC<NUMBER, also <=, > and >=. Metrics: p50, p90, p99, p99.9, mean, max (with unit us, ms or s), fps,
mpoints (million points a second), errors (share of the frames, with %), least-share (the results of the client with the
fewest, as a share of the clients' mean, with %).)";

HelpText help() {
  return {.common = {"--clients", "--rate", "--arrivals", "--duration", "--input", "--codec", "--verify", "--objective",
                     "--topic", "--speed", "--json", "--server", "--method"},
          .examples = R"(segctl bench --clients 4 --duration 10
segctl bench --rate 30 --objective "p99<50ms" --objective "errors<=0%" --json -
segctl bench --input scene1.pcd scene2.pcd --clients 8 --in-flight 2 --verify
segctl bench --input run.mcap --topic /points --clients 4 --objective "p99<100ms"
segctl bench --clients 32 --codec planar,quantised,rgbd --objective "least-share>=50%")",
          .details = kDetails,
          .exit_codes =
              "0 success, every objective was met; 1 an objective was missed, a label array differs (--verify),\n"
              "or there is no server; 2 bad input or usage."};
}

struct BenchArguments {
  OptionFlags options;
  ServerFlags server;
  std::size_t clients = 1;
  std::optional<std::size_t> in_flight;
  double rate = 0;
  std::string arrivals = "constant";
  double duration_s = 10;
  double warm_up_s = 1;
  std::uint64_t seed = 1;
  std::vector<std::string> inputs;
  RecordingFlags recording;
  double speed = 1;
  CLI::Option* speed_flag = nullptr;
  std::string size = "640x480";
  std::size_t scenes = 4;
  CodecFlags codec;
  bool encoded_beforehand = false;
  bool verify = false;
  std::vector<std::string> outputs{"labels"};
  std::vector<std::string> objectives;
  JsonFlag json;

  void add_to(CLI::App& app);
  bool has_recording() const { return inputs.size() == 1 && is_recording_file(inputs.front()); }
  /// Whether frames come at the times at which they were recorded.
  bool replays() const { return has_recording() && rate == 0; }

 private:
  void add_load_flags(CLI::App& app);
  void add_frame_flags(CLI::App& app);
};

void BenchArguments::add_load_flags(CLI::App& app) {
  const std::string group = "Load";
  app.add_option("--clients", clients, "number of robots at the same time, each with a connection of its own")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str()
      ->group(group);
  app.add_option("--in-flight", in_flight,
                 fmt::format("most unanswered frames of a client; default 1, with --rate {}", kOpenLoopInFlight))
      ->check(CLI::Range(1, 256))
      ->group(group);
  CLI::Option* rate_flag = app.add_option("--rate", rate, "open loop: frames a second of all clients together")
                               ->check(CLI::Range(0.001, 1e6))
                               ->group(group);
  app.add_option("--arrivals", arrivals, "when frames are due in an open loop")
      ->check(CLI::IsMember({"constant", "poisson"}))
      ->capture_default_str()
      ->needs(rate_flag)
      ->group(group);
  app.add_option("--duration", duration_s, "seconds that are measured")
      ->check(CLI::Range(0.1, 86400.0))
      ->capture_default_str()
      ->group(group);
  app.add_option("--warm-up", warm_up_s, "seconds before the measurement")
      ->check(CLI::Range(0.0, 3600.0))
      ->capture_default_str()
      ->group(group);
}

void BenchArguments::add_frame_flags(CLI::App& app) {
  const std::string group = "Frames";
  CLI::Option* input_flag =
      app.add_option("--input", inputs,
                     "files of clouds, or one recording (MCAP or ROS 1 bag); default: synthetic scenes")
          ->type_name("FILES")
          ->group(group);
  recording.add_to(app);
  speed_flag = app.add_option("--speed", speed, "how much faster than recorded frames come; 0: closed loop")
                   ->check(CLI::Range(0.0, 1000.0))
                   ->capture_default_str()
                   ->excludes("--rate")
                   ->group(RecordingFlags::kGroup);
  app.add_option("--size", size, "size of synthetic frames in pixels")
      ->type_name("WxH")
      ->capture_default_str()
      ->excludes(input_flag)
      ->group(group);
  app.add_option("--scenes", scenes, "number of different synthetic frames")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str()
      ->excludes(input_flag)
      ->group(group);
  app.add_option("--seed", seed, "seed of synthetic frames and random arrivals")
      ->check(not_negative())
      ->capture_default_str()
      ->group(group);
  codec.add_to(app, "default: planar; several, as planar,rgbd: clients use them in turn", group);
  app.add_flag("--encoded-beforehand", encoded_beforehand, "encode every frame once, before the run")->group(group);
  app.add_option("--outputs", outputs, "arrays in the answers: labels, supervoxels, tree, segments")
      ->check(CLI::IsMember({"labels", "supervoxels", "tree", "segments"}))
      ->delimiter(',')
      ->capture_default_str()
      ->group(group);
}

void BenchArguments::add_to(CLI::App& app) {
  add_load_flags(app);
  add_frame_flags(app);
  app.add_flag("--verify", verify, "compare every label array with a local run on what the server decodes")
      ->group("Result");
  app.add_option("--objective", objectives, "what the run must reach, e.g. \"p99<50ms\"; may be repeated")
      ->type_name("TEXT")
      ->group("Result");
  json.add_to(app, "write the measurements as one JSON object");
  server.add_to(app, kDefaultTimeout);
  options.add_to(app);
}

using SharedClouds = std::vector<std::shared_ptr<const Cloud>>;

absl::StatusOr<SharedClouds> load_files(const BenchArguments& arguments) {
  if (arguments.recording.given() || arguments.speed_flag->count() > 0) {
    return absl::InvalidArgumentError("--topic, --color-topic, --camera-info-topic and --speed are for one recording");
  }
  SharedClouds clouds;
  for (const std::string& path : arguments.inputs) {
    ASSIGN_OR_RETURN(const std::string bytes, read_input(path));
    auto scene = codec::decode_cloud(std::as_bytes(std::span(bytes)), {});
    if (!scene.ok()) return with_prefix(input_name(path), scene.status());
    clouds.push_back(std::make_shared<const Cloud>(std::move(scene->cloud)));
  }
  return clouds;
}

absl::StatusOr<SharedClouds> make_scenes(const BenchArguments& arguments) {
  synth::SceneOptions options;
  int end = 0;
  const bool parsed = std::sscanf(arguments.size.c_str(), "%5ux%5u%n", &options.width, &options.height, &end) == 2;
  if (!parsed || static_cast<std::size_t>(end) != arguments.size.size()) {
    return absl::InvalidArgumentError(fmt::format("--size {}: must be WIDTHxHEIGHT, e.g. 640x480", arguments.size));
  }
  SharedClouds clouds;
  for (std::size_t i = 0; i < arguments.scenes; ++i) {
    options.seed = arguments.seed + i;
    ASSIGN_OR_RETURN(auto scene, synth::make_tabletop(options));
    clouds.push_back(std::make_shared<const Cloud>(std::move(scene.cloud)));
  }
  return clouds;
}

std::chrono::milliseconds to_milliseconds(double seconds) {
  return std::chrono::milliseconds(static_cast<std::int64_t>(seconds * 1000));
}

absl::StatusOr<bench::LoadOptions> load_options(const BenchArguments& arguments) {
  bench::LoadOptions load;
  ASSIGN_OR_RETURN(const auto timeout, arguments.server.timeout());
  load.client = {.address = arguments.server.address(), .timeout = timeout};
  load.stream.client_name = "segctl bench";
  ASSIGN_OR_RETURN(load.stream.options, arguments.options.options());
  const auto wants = [&](const char* name) {
    return std::ranges::find(arguments.outputs, name) != arguments.outputs.end();
  };
  load.stream.outputs = {.labels = wants("labels"),
                         .supervoxels = wants("supervoxels"),
                         .tree = wants("tree"),
                         .segments = wants("segments")};
  if (arguments.verify && !load.stream.outputs.labels) {
    return absl::InvalidArgumentError("--verify needs labels among --outputs");
  }
  load.stream.order = client::Order::kDone;
  load.rate = arguments.rate;
  load.replay_speed = arguments.replays() ? arguments.speed : 0;
  load.stream.max_in_flight = arguments.in_flight.value_or(load.is_open() ? kOpenLoopInFlight : 1);
  load.stream.max_waiting = load.is_open() ? kOpenLoopWaiting : 1;
  load.stream.frame_timeout = timeout;
  load.clients = arguments.clients;
  load.poisson = arguments.arrivals == "poisson";
  load.seed = arguments.seed;
  load.warm_up = to_milliseconds(arguments.warm_up_s);
  load.duration = to_milliseconds(arguments.duration_s);
  load.encoded_beforehand = arguments.encoded_beforehand;
  load.verify = arguments.verify;
  return load;
}

absl::StatusOr<bench::FrameSource> frame_source(const BenchArguments& arguments) {
  bench::FrameSource source;
  if (arguments.has_recording()) {
    ASSIGN_OR_RETURN(source, load_recording(arguments.inputs.front(), arguments.recording));
  } else {
    ASSIGN_OR_RETURN(source.clouds, arguments.inputs.empty() ? make_scenes(arguments) : load_files(arguments));
  }
  ASSIGN_OR_RETURN(const auto codecs, arguments.codec.list());
  for (const wire::CodecOptions& options : codecs) {
    source.encodings.push_back(
        {std::string(wire::info(options.codec).name),
         [options](std::shared_ptr<const Cloud> cloud) { return client::cloud_payload(std::move(cloud), options); },
         answer_compression(options)});
  }
  return source;
}

/// Frames a second that an open loop offers.
double offered_rate(const bench::LoadOptions& load, const bench::FrameSource& source) {
  if (load.replay_speed == 0) return load.rate;
  const auto frames = static_cast<double>(load.clients * source.times.size());
  return frames * load.replay_speed / bench::round_seconds(source.times);
}

/// For example "planar, rgbd".
std::string names_of(const std::vector<bench::Encoding>& encodings) {
  std::string names;
  for (const bench::Encoding& encoding : encodings) {
    names += fmt::format("{}{}", names.empty() ? "" : ", ", encoding.name);
  }
  return names;
}

absl::StatusOr<std::vector<bench::Objective>> parse_objectives(const BenchArguments& arguments) {
  std::vector<bench::Objective> all;
  for (const std::string& text : arguments.objectives) {
    ASSIGN_OR_RETURN(all.emplace_back(), bench::parse_objective(text));
  }
  return all;
}

/// The first reason for an exit code other than 0, or OK.
absl::Status verdict(const bench::Report& report, const std::vector<bench::Objective>& wanted) {
  if (report.mismatches > 0) {
    return absl::InternalError(
        fmt::format("{} of {} label arrays differ from those of a local run", report.mismatches, report.verified));
  }
  std::string missed;
  for (const bench::Objective& objective : wanted) {
    if (is_met(objective, report)) continue;
    missed +=
        fmt::format("{}{} (reached {:.3f})", missed.empty() ? "" : ", ", objective.text, value(objective, report));
  }
  if (!missed.empty()) return absl::FailedPreconditionError(fmt::format("missed: {}", missed));
  if (report.results == 0) {
    const std::string why = report.errors.empty() ? "none was sent" : report.errors.begin()->first;
    return absl::UnavailableError(fmt::format("no frame got a result: {}", why));
  }
  return absl::OkStatus();
}

absl::StatusOr<bench::Report> run_with_progress(const bench::LoadOptions& load, const bench::FrameSource& source) {
  const ProgressBar bar("bench");
  return bench::run_load(load, source, [&bar](double share) { bar.show(static_cast<std::size_t>(share * 100), 100); });
}

absl::Status run(const BenchArguments& arguments) {
  StagedOutput output;
  RETURN_IF_ERROR(arguments.json.announce(output));
  ASSIGN_OR_RETURN(const auto objectives, parse_objectives(arguments));
  ASSIGN_OR_RETURN(const auto load, load_options(arguments));
  ASSIGN_OR_RETURN(const auto source, frame_source(arguments));
  ASSIGN_OR_RETURN(const auto client, arguments.server.connect());
  RETURN_IF_ERROR(client.server_info().status());  // Without a server there is nothing to measure.

  ASSIGN_OR_RETURN(const auto report, run_with_progress(load, source));
  const BenchSummary summary{
      report, load, objectives, arguments.server.address(), names_of(source.encodings), offered_rate(load, source)};
  arguments.json.add(output, to_json(summary));
  if (!output.uses_stdout()) output.add("-", to_text(summary));
  RETURN_IF_ERROR(output.commit());
  return verdict(report, objectives);
}

}  // namespace

void add_bench_command(CLI::App& app, Command& chosen) {
  add_command(app, chosen, "bench", "Load a server, and measure latency and throughput", help(), run);
}

}  // namespace segserve::segctl
