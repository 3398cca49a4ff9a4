// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/bench_arguments.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "client/segctl/bench_schedule.hpp"
#include "command_line/not_negative.hpp"
#include "command_line/number_range.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "credentials/shared_secret.hpp"
#include "fmt/format.h"

namespace segserve::segctl {
namespace {

constexpr double kDefaultTimeout = 30;
constexpr double kLongestDrain = 10;
constexpr double kInterval = 1, kSoakInterval = 60;
constexpr std::size_t kOpenLoopInFlight = 8;
constexpr std::size_t kOpenLoopWaiting = 1024;  // An open loop must not wait until the stream takes a frame.

std::chrono::milliseconds to_milliseconds(double seconds) {
  return std::chrono::milliseconds(static_cast<std::int64_t>(seconds * 1000));
}

}  // namespace

void BenchArguments::add_load_flags(CLI::App& app) {
  const std::string group = "Load";
  app.add_option(
         "--clients", clients,
         "number of robots at the same time, each with a connection of its own; 1..32: a run for 1, 2, 4 and so "
         "on")
      ->type_name("COUNT")
      ->check(CLI::Validator([](const std::string& text) { return message_of(parse_clients(text).status()); }, ""))
      ->capture_default_str()
      ->group(group);
  app.add_option("--in-flight", in_flight,
                 fmt::format("most unanswered frames of a client; default 1, with --rate {}", kOpenLoopInFlight))
      ->check(CLI::Range(1, 256))
      ->group(group);
  app.add_option("--hedge-after", hedge_after_ms,
                 "send a frame without an outcome after this many milliseconds to a second server; 0: never")
      ->type_name("MS")
      ->check(number_range(0.0, 86'400'000.0))
      ->capture_default_str()
      ->group(group);
  app.add_flag("--drop-oldest", drop_oldest,
               "open loop: at most one frame waits, and makes way for the next one, as on robots")
      ->group(group);
  app.add_option("--duration", duration_s, "seconds that are measured")
      ->check(number_range(0.1, 86400.0))
      ->capture_default_str()
      ->group(group);
  app.add_option("--warm-up", warm_up_s, "seconds before the measurement")
      ->check(number_range(0.0, 3600.0))
      ->capture_default_str()
      ->group(group);
  app.add_option("--drain", drain_s,
                 fmt::format("most seconds to wait for outcomes after the last frame; default --timeout, at most {}",
                             kLongestDrain))
      ->type_name("SECONDS")
      ->check(number_range(0.0, 86400.0))
      ->group(group);
}

void BenchArguments::add_schedule_flags(CLI::App& app) {
  const std::string group = "Load";
  app.add_option("--rate", rate, "open loop: frames a second of all clients together")
      ->check(number_range(0.001, 1e6))
      ->group(group);
  app.add_option("--arrivals", arrivals, "when frames are due in an open loop")
      ->check(CLI::IsMember({"constant", "poisson"}))
      ->capture_default_str()
      ->group(group);
  app.add_option("--steps", steps, "open loop: one rate after the other, e.g. 10,20,40:10s")
      ->type_name("RATES:TIME")
      ->excludes("--rate")
      ->excludes("--duration")
      ->group(group);
  app.add_option("--ramp", ramp, "open loop: a rate that grows or falls evenly, e.g. 10:200:10s")
      ->type_name("RATE:RATE:TIME")
      ->excludes("--rate")
      ->excludes("--steps")
      ->excludes("--duration")
      ->group(group);
  app.add_option(
         "--search", search,
         "find the highest rate that meets this objective, e.g. \"p99<50ms\"; each try takes --duration; begins "
         "with --rate")
      ->type_name("TEXT")
      ->excludes("--steps")
      ->excludes("--ramp")
      ->group(group);
  app.add_option("--until-stable", until_stable,
                 fmt::format("measure windows of --duration until three in a row agree so well, e.g. 5%; at most {}",
                             bench::kMostWindows))
      ->type_name("SHARE")
      ->excludes("--steps")
      ->excludes("--ramp")
      ->excludes("--search")
      ->group(group);
}

void BenchArguments::add_fault_flags(CLI::App& app) {
  app.add_option("--soak", soak, "measure for so long, e.g. 4h, and tell how it goes once a minute")
      ->type_name("TIME")
      ->excludes("--duration")
      ->excludes("--steps")
      ->excludes("--ramp")
      ->excludes("--search")
      ->excludes("--until-stable")
      ->group("Load");
  app.add_option("--agents", agents, "have these agents generate the load; several are separated by commas")
      ->type_name("HOST:PORT,..")
      ->excludes("--until-stable")
      ->group("Load");
  CLI::Option* agent_flag = app.add_option("--agent", agent, "be an agent for other load tests: wait for them here")
                                ->type_name("HOST:PORT")
                                ->excludes("--agents")
                                ->group("Load");
  CLI::Option* token_flag =
      app.add_option("--agent-token-file", agent_token_file,
                     "file with the secret that agents share with the load tests that may use them, at least 16 bytes; "
                     "it is never sent")
          ->type_name("FILE")
          ->group("Load");
  app.add_flag("--agent-for-anyone", agent_for_anyone,
               "let other machines reach the agent without a secret; it can then load any server for whoever does")
      ->needs(agent_flag)
      ->excludes(token_flag)
      ->group("Load");
  app.add_option("--fault", fault,
                 "clients that misbehave beside those that are measured, e.g. "
                 "slow-reader=2,vanish=1%,malformed=1%,cancel=1%")
      ->type_name("KIND=AMOUNT")
      ->group("Load");
}

void BenchArguments::add_frame_flags(CLI::App& app) {
  const std::string group = "Frames";
  CLI::Option* input_flag =
      app.add_option(
             "--input", inputs,
             "files of clouds and folders of them, or one recording (MCAP or ROS 1 bag); default: synthetic scenes")
          ->type_name("FILES")
          ->group(group);
  recording.add_to(app);
  speed_flag = app.add_option("--speed", speed, "how much faster than recorded frames come; 0: closed loop")
                   ->check(number_range(0.0, 1000.0))
                   ->capture_default_str()
                   ->excludes("--rate")
                   ->excludes("--steps")
                   ->excludes("--ramp")
                   ->excludes("--search")
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

void BenchArguments::add_result_flags(CLI::App& app) {
  app.add_flag("--verify", verify, "compare every label array with a local run on what the server decodes")
      ->group("Result");
  app.add_option("--objective", objectives, "what the run must reach, e.g. \"p99<50ms\"; may be repeated")
      ->type_name("TEXT")
      ->group("Result");
  app.add_option("--interval", interval_s, "seconds of an interval of the timeline; default 1, with --soak 60")
      ->check(number_range(0.1, 3600.0))
      ->type_name("SECONDS")
      ->group("Result");
  app.add_option("--metrics", metrics, "read the metrics of the server here before and after, e.g. 127.0.0.1:9464")
      ->type_name("URL")
      ->group("Result");
  app.add_option("--metrics-listen", metrics_listen,
                 "serve the figures of this process here as metrics for Prometheus, while the load runs")
      ->type_name("HOST:PORT")
      ->excludes("--agents")
      ->group("Result");
  json.add_to(app, "write the measurements as one JSON object");
  html.add_to(app);
  app.add_option("--csv", csv, "write what happened in each second as a table; - is standard output")
      ->type_name("FILE")
      ->group("Output");
  app.add_option("--hdr-log", hdr_log,
                 "write the latencies of each second as a log of HdrHistogram; - is standard output")
      ->type_name("FILE")
      ->group("Output");
}

void BenchArguments::add_to(CLI::App& app) {
  add_load_flags(app);
  add_schedule_flags(app);
  add_fault_flags(app);
  add_frame_flags(app);
  add_result_flags(app);
  server.add_to(app, kDefaultTimeout);
  options.add_to(app);
}

absl::StatusOr<std::string> BenchArguments::agent_secret() const {
  if (agent_token_file.empty()) return std::string();
  auto secret = credentials::read_shared_secret(agent_token_file);
  if (!secret.ok()) return with_prefix("--agent-token-file", secret.status());
  return secret;
}

absl::Status BenchArguments::add_stream_options(bench::LoadOptions& load) const {
  client::StreamOptions& stream = load.stream;
  ASSIGN_OR_RETURN(stream.options, options.options());
  ASSIGN_OR_RETURN(stream.frame_timeout, server.timeout());
  stream.client_name = "segctl bench";
  const auto wants = [&](const char* name) { return std::ranges::find(outputs, name) != outputs.end(); };
  stream.outputs = {.labels = wants("labels"),
                    .supervoxels = wants("supervoxels"),
                    .tree = wants("tree"),
                    .segments = wants("segments")};
  if (verify && !stream.outputs.labels) return absl::InvalidArgumentError("--verify needs labels among --outputs");
  stream.order = client::Order::kDone;
  stream.max_in_flight = in_flight.value_or(load.is_open() ? kOpenLoopInFlight : 1);
  stream.max_waiting = load.is_open() ? kOpenLoopWaiting : 1;
  stream.hedge_after = to_milliseconds(hedge_after_ms / 1000);
  if (!drop_oldest) return absl::OkStatus();
  if (!load.is_open())
    return absl::InvalidArgumentError("--drop-oldest needs --rate, or a recording or a folder with times");
  stream.when_behind = client::WhenBehind::kDropOldest;
  stream.max_waiting = 1;
  return absl::OkStatus();
}

absl::Status BenchArguments::add_schedule(bench::LoadPlan& plan) const {
  bench::LoadOptions& load = plan.load;
  load.duration = to_milliseconds(duration_s);
  if (soaks()) {
    ASSIGN_OR_RETURN(load.duration, parse_duration("--soak", soak));
  }
  const double seconds = std::chrono::duration<double>(load.duration).count();
  load.replay_speed = replays() ? speed : 0;
  if (rate > 0) load.rates = {{rate, rate, seconds}};
  if (!search.empty()) {
    ASSIGN_OR_RETURN(plan.search, bench::parse_objective(search, "--search"));
    if (rate > 0) plan.search_first = rate;
    load.rates = {{1, 1, seconds}};  // each try sets its own
  }
  if (!until_stable.empty()) {
    ASSIGN_OR_RETURN(plan.until_stable, parse_share("--until-stable", until_stable));
  }
  if (!steps.empty() || !ramp.empty()) {
    ASSIGN_OR_RETURN(LoadSchedule schedule, steps.empty() ? parse_ramp(ramp) : parse_steps(steps));
    load.duration = schedule.duration();
    load.rates = std::move(schedule.rates);
    load.levels = std::move(schedule.levels);
    plan.level_labels = std::move(schedule.labels);
  }
  load.poisson = arrivals == "poisson";
  if (load.poisson && load.rates.empty()) {
    return absl::InvalidArgumentError("--arrivals poisson needs --rate, --steps, --ramp or --search");
  }
  return absl::OkStatus();
}

absl::StatusOr<bench::LoadPlan> BenchArguments::plan() const {
  bench::LoadPlan plan;
  bench::LoadOptions& load = plan.load;
  ASSIGN_OR_RETURN(plan.client_counts, parse_clients(clients));
  if (plan.client_counts.size() > 1) {
    for (const auto& [flag, is_given] : {std::pair("--search", !search.empty()),
                                         {"--steps", !steps.empty()},
                                         {"--ramp", !ramp.empty()},
                                         {"--until-stable", !until_stable.empty()}}) {
      if (is_given) return absl::InvalidArgumentError(fmt::format("{} needs one number of --clients", flag));
    }
  }
  ASSIGN_OR_RETURN(const auto codecs, codec.list());
  if (const std::size_t most = std::ranges::max(plan.client_counts); most < codecs.size()) {
    return absl::InvalidArgumentError(fmt::format(
        "--codec has {} codecs, but there are only {} clients, each of which uses one", codecs.size(), most));
  }
  RETURN_IF_ERROR(add_schedule(plan));
  ASSIGN_OR_RETURN(load.client, server.options());
  RETURN_IF_ERROR(add_stream_options(load));
  load.clients = plan.client_counts.front();
  load.seed = seed;
  load.warm_up = to_milliseconds(warm_up_s);
  load.drain =
      drain_s ? to_milliseconds(*drain_s) : std::min(load.stream.frame_timeout, to_milliseconds(kLongestDrain));
  load.interval_s = interval_s > 0 ? interval_s : soaks() ? kSoakInterval : kInterval;
  load.encoded_beforehand = encoded_beforehand;
  load.verify = verify;
  return plan;
}

absl::StatusOr<std::vector<bench::Objective>> BenchArguments::parsed_objectives() const {
  std::vector<bench::Objective> all;
  for (const std::string& text : objectives) {
    ASSIGN_OR_RETURN(all.emplace_back(), bench::parse_objective(text));
  }
  return all;
}

}  // namespace segserve::segctl
