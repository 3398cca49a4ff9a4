#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "client/load_test/load.hpp"
#include "client/load_test/load_report.hpp"
#include "client/load_test/objective.hpp"
#include "client/segctl/bench_summary.hpp"
#include "client/segctl/codec_flags.hpp"
#include "client/segctl/command.hpp"
#include "client/segctl/input_file.hpp"
#include "client/segctl/option_flags.hpp"
#include "client/segctl/progress_bar.hpp"
#include "client/segctl/server_flags.hpp"
#include "client/segctl/staged_output.hpp"
#include "core/lab/synth/scene.hpp"
#include "fmt/format.h"
#include "nlohmann/json.hpp"
#include "segserve/codec/cloud_file.hpp"
#include "segserve/v1/server_info.pb.h"

namespace segserve::segctl {
namespace {

constexpr double kDefaultTimeout = 30;
constexpr std::size_t kOpenLoopInFlight = 8;

constexpr const char* kFooter = R"(Examples:
  segctl bench --clients 4 --duration 10
  segctl bench --rate 30 --objective "p99<50ms" --objective "errors<=0%" --json -
  segctl bench --input scene1.pcd scene2.pcd --clients 8 --in-flight 2 --verify
  segctl bench --clients 32 --codec planar,quantised,rgbd --objective "least-share>=50%"

Without --rate the loop is closed: every client sends a frame as soon as it has fewer than --in-flight
unanswered ones. With it the loop is open: frames are meant to go at their time, whatever became of those
before. Latency counts from that intended time to the decoded result, so that a server that stalls
does not hide the frames it held up; "since sent" counts from the actual hand-over.

Objectives are METRIC<NUMBER, also <=, >, >=; metrics: p50, p90, p99, p99.9, mean, max (with unit us,
ms or s), fps, mpoints (million points a second), errors (share of the frames, with %), least-share
(the results of the client with the fewest, as a share of the clients' mean, with %).

Exit codes: 0 done, all objectives met; 1 an objective missed, a label array that differs (--verify),
or no server; 2 bad input or usage.)";

struct Arguments {
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
  std::string size = "640x480";
  std::size_t scenes = 4;
  CodecFlags codec;
  bool encoded_beforehand = false;
  bool verify = false;
  std::vector<std::string> outputs{"labels"};
  std::vector<std::string> objectives;
  std::string json_path;
};

void add_flags(CLI::App& app, Arguments& a) {
  app.add_option("--clients", a.clients, "robots at the same time, each with a connection of its own")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str()
      ->group("Load");
  app.add_option("--in-flight", a.in_flight,
                 fmt::format("unanswered frames of a client at most; default 1, with --rate {}", kOpenLoopInFlight))
      ->check(CLI::Range(1, 256))
      ->group("Load");
  CLI::Option* rate = app.add_option("--rate", a.rate, "open loop: frames a second, of all clients together")
                          ->check(CLI::Range(0.001, 1e6))
                          ->group("Load");
  app.add_option("--arrivals", a.arrivals, "of an open loop")
      ->check(CLI::IsMember({"constant", "poisson"}))
      ->capture_default_str()
      ->needs(rate)
      ->group("Load");
  app.add_option("--duration", a.duration_s, "seconds that are measured")
      ->check(CLI::Range(0.1, 86400.0))
      ->capture_default_str()
      ->group("Load");
  app.add_option("--warm-up", a.warm_up_s, "seconds before that")
      ->check(CLI::Range(0.0, 3600.0))
      ->capture_default_str()
      ->group("Load");
  CLI::Option* inputs = app.add_option("--input", a.inputs, "PCD or PLY files; default: synthetic scenes")
                            ->type_name("FILES")
                            ->group("Frames");
  app.add_option("--size", a.size, "of synthetic frames, pixels")
      ->type_name("WxH")
      ->capture_default_str()
      ->excludes(inputs)
      ->group("Frames");
  app.add_option("--scenes", a.scenes, "how many different synthetic frames")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str()
      ->excludes(inputs)
      ->group("Frames");
  app.add_option("--seed", a.seed, "of synthetic frames and random arrivals")->capture_default_str()->group("Frames");
  a.codec.add_to(app, "default: planar; several, as planar,rgbd: clients use them in turn", "Frames");
  app.add_flag("--encoded-beforehand", a.encoded_beforehand, "encode every frame once, before the run")
      ->group("Frames");
  app.add_option("--outputs", a.outputs, "what the answers hold: labels, supervoxels, tree, segments")
      ->check(CLI::IsMember({"labels", "supervoxels", "tree", "segments"}))
      ->delimiter(',')
      ->capture_default_str()
      ->group("Frames");
  app.add_flag("--verify", a.verify, "compare every label array with a local run on what the server decodes")
      ->group("Result");
  app.add_option("--objective", a.objectives, "what the run must reach, e.g. \"p99<50ms\"; may be repeated")
      ->type_name("TEXT")
      ->group("Result");
  app.add_option("--json", a.json_path, "write the measurements as one JSON object; - is standard output")
      ->type_name("FILE")
      ->group("Result");
  a.server.add_to(app, kDefaultTimeout);
  a.options.add_to(app);
}

using SharedClouds = std::vector<std::shared_ptr<const Cloud>>;

absl::StatusOr<SharedClouds> load_files(const std::vector<std::string>& paths) {
  SharedClouds clouds;
  for (const std::string& path : paths) {
    const auto bytes = read_input(path);
    if (!bytes.ok()) return bytes.status();
    auto scene = codec::decode_cloud(std::as_bytes(std::span(*bytes)), {});
    if (!scene.ok()) {
      return absl::Status(scene.status().code(),
                          fmt::format("{}: {}", input_name(path), std::string(scene.status().message())));
    }
    clouds.push_back(std::make_shared<const Cloud>(std::move(scene->cloud)));
  }
  return clouds;
}

absl::StatusOr<SharedClouds> make_scenes(const Arguments& arguments) {
  synth::SceneOptions options;
  int end = 0;
  const bool parsed = std::sscanf(arguments.size.c_str(), "%5ux%5u%n", &options.width, &options.height, &end) == 2;
  if (!parsed || static_cast<std::size_t>(end) != arguments.size.size()) {
    return absl::InvalidArgumentError(fmt::format("--size {}: must be WIDTHxHEIGHT, e.g. 640x480", arguments.size));
  }
  SharedClouds clouds;
  for (std::size_t i = 0; i < arguments.scenes; ++i) {
    options.seed = arguments.seed + i;
    auto scene = synth::make_tabletop(options);
    if (!scene.ok()) return scene.status();
    clouds.push_back(std::make_shared<const Cloud>(std::move(scene->cloud)));
  }
  return clouds;
}

std::chrono::milliseconds to_milliseconds(double seconds) {
  return std::chrono::milliseconds(static_cast<std::int64_t>(seconds * 1000));
}

absl::StatusOr<bench::LoadOptions> load_options(const Arguments& arguments) {
  const auto timeout = arguments.server.timeout();
  if (!timeout.ok()) return timeout.status();
  const auto options = arguments.options.options();
  if (!options.ok()) return options.status();
  bench::LoadOptions load;
  load.client = {.address = arguments.server.address(), .timeout = *timeout};
  load.stream.client_name = "segctl bench";
  load.stream.options = *options;
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
  load.stream.max_in_flight = arguments.in_flight.value_or(arguments.rate > 0 ? kOpenLoopInFlight : 1);
  load.stream.max_waiting = arguments.rate > 0 ? 1024 : 1;  // a sender that had to wait would not be an open loop
  load.stream.frame_timeout = *timeout;
  load.clients = arguments.clients;
  load.rate = arguments.rate;
  load.poisson = arguments.arrivals == "poisson";
  load.seed = arguments.seed;
  load.warm_up = to_milliseconds(arguments.warm_up_s);
  load.duration = to_milliseconds(arguments.duration_s);
  load.encoded_beforehand = arguments.encoded_beforehand;
  load.verify = arguments.verify;
  return load;
}

absl::StatusOr<bench::FrameSource> frame_source(const Arguments& arguments) {
  auto clouds = arguments.inputs.empty() ? make_scenes(arguments) : load_files(arguments.inputs);
  if (!clouds.ok()) return clouds.status();
  const auto codecs = arguments.codec.list();
  if (!codecs.ok()) return codecs.status();
  bench::FrameSource source{*std::move(clouds), {}};
  for (const wire::CodecOptions& options : *codecs) {
    source.encodings.push_back(
        {std::string(wire::info(options.codec).name),
         [options](std::shared_ptr<const Cloud> cloud) { return client::cloud_payload(std::move(cloud), options); },
         answer_compression(options)});
  }
  return source;
}

/// "planar, rgbd".
std::string names(const std::vector<bench::Encoding>& encodings) {
  std::string names;
  for (const bench::Encoding& encoding : encodings)
    names += fmt::format("{}{}", names.empty() ? "" : ", ", encoding.name);
  return names;
}

absl::StatusOr<std::vector<bench::Objective>> objectives(const Arguments& arguments) {
  std::vector<bench::Objective> all;
  for (const std::string& text : arguments.objectives) {
    const auto objective = bench::parse_objective(text);
    if (!objective.ok()) return objective.status();
    all.push_back(*objective);
  }
  return all;
}

/// The first reason for an exit code other than 0.
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

absl::Status run(const Arguments& arguments) {
  StagedOutput output;
  if (!arguments.json_path.empty()) {
    if (absl::Status status = output.announce(arguments.json_path); !status.ok()) return status;
  }
  const auto wanted = objectives(arguments);
  if (!wanted.ok()) return wanted.status();
  const auto load = load_options(arguments);
  if (!load.ok()) return load.status();
  const auto source = frame_source(arguments);
  if (!source.ok()) return source.status();
  const auto client = arguments.server.connect();
  if (!client.ok()) return client.status();
  if (const auto info = client->server_info(); !info.ok()) return info.status();  // before a run that nobody answers

  absl::StatusOr<bench::Report> report = absl::UnknownError("");
  {
    const ProgressBar bar("bench");
    report =
        bench::run_load(*load, *source, [&bar](double share) { bar.show(static_cast<std::size_t>(share * 100), 100); });
  }
  if (!report.ok()) return report.status();
  const BenchSummary summary{*report, *load, *wanted, arguments.server.address(), names(source->encodings)};
  if (!arguments.json_path.empty()) output.add(arguments.json_path, to_json(summary).dump() + "\n");
  if (!output.uses_stdout()) output.add("-", to_text(summary));
  if (absl::Status status = output.commit(); !status.ok()) return status;
  return verdict(*report, *wanted);
}

}  // namespace

void add_bench_command(CLI::App& app, Command& chosen) {
  CLI::App* command = app.add_subcommand("bench", "Load a server, and measure latency and throughput");
  auto arguments = std::make_shared<Arguments>();
  add_flags(*command, *arguments);
  command->footer(kFooter);
  command->callback([arguments, &chosen] { chosen = [arguments] { return run(*arguments); }; });
}

}  // namespace segserve::segctl
