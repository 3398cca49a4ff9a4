// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <utility>

#include "client/load_test/load.hpp"
#include "client/segctl/bench_agent.hpp"
#include "client/segctl/bench_arguments.hpp"
#include "client/segctl/bench_csv.hpp"
#include "client/segctl/bench_frames.hpp"
#include "client/segctl/bench_json.hpp"
#include "client/segctl/bench_measure.hpp"
#include "client/segctl/bench_summary.hpp"
#include "client/segctl/bench_text.hpp"
#include "client/segctl/command.hpp"
#include "client/segctl/output_kind.hpp"
#include "client/segctl/server_info_json.hpp"
#include "client/segctl/staged_output.hpp"
#include "core/base/status_macros.hpp"
#include "nlohmann/json.hpp"
#include "segserve/v1/segmentation_service.pb.h"

namespace segserve::segctl {
namespace {

constexpr const char* kDetails =
    R"(Without --rate the loop is closed: every client sends a frame as soon as it has fewer than --in-flight unanswered ones.
With --rate, --steps, --ramp or --search it is open: frames are due at fixed or random times, whatever became of earlier
frames. Latency counts from the time at which a frame was due until its result is decoded, so that a server that stalls
does not hide the frames that it held up. A frame that failed is infinitely late. "since sent" counts from the time at
which the frame's first byte was sent. Throughput is of the results that came within the measured window.

A recording is an open loop, too: every client replays it over and over, with the times at which its frames were
recorded. Clients begin at different frames. --speed 0 makes it a closed loop. So is a folder that tells when its clouds
were captured, by a sequence.json (as segctl synth --moving writes it) or by names like 1305031102.175304.pcd.

Objectives are METRIC<NUMBER, also <=, > and >=. Metrics: p50, p90, p95, p99, p99.9, p99.99, mean, max (with unit us, ms
or s), fps, mpoints (million points a second), errors (share of the frames, with %), least-share (the results of the
client with the fewest, as a share of the clients' mean, with %).

A percentile in parentheses has fewer than five frames beyond it and means little. docs/load_testing.md has the method
and the keys of the JSON.)";

HelpText help() {
  return {.common = {"--clients", "--rate", "--steps", "--search", "--duration", "--input", "--codec", "--verify",
                     "--objective", "--topic", "--speed", "--json", "--html", "--server", "--method"},
          .examples = R"(segctl bench --clients 4 --duration 10
segctl bench --rate 30 --objective "p99<50ms" --objective "errors<=0%" --json -
segctl bench --search "p99<50ms" --clients 8 --html report.html
segctl bench --clients 1..32 --codec planar,quantised,rgbd
segctl bench --input run.mcap --topic /points --clients 4 --objective "p99<100ms"
segctl bench --soak 4h --rate 20 --metrics 127.0.0.1:9464)",
          .details = kDetails,
          .exit_codes =
              "0 success, every objective was met; 1 an objective was missed, frames failed and no objective\n"
              "on errors allows it, a label array differs (--verify), or there is no server; 2 bad input or usage;\n"
              "130 Ctrl-C, what was measured is reported."};
}

/// The files that the flags name.
absl::Status announce(const BenchArguments& arguments, StagedOutput& output) {
  RETURN_IF_ERROR(arguments.json.announce(output));
  RETURN_IF_ERROR(arguments.html.announce(output));
  if (!arguments.csv.empty()) {
    RETURN_IF_ERROR(output.announce(arguments.csv));
    RETURN_IF_ERROR(check_output_name("--csv", arguments.csv, OutputKind::kCsv));
  }
  if (arguments.hdr_log.empty()) return absl::OkStatus();
  RETURN_IF_ERROR(output.announce(arguments.hdr_log));
  return check_output_name("--hdr-log", arguments.hdr_log, OutputKind::kHistogramLog);
}

absl::Status run(const BenchArguments& arguments) {
  if (!arguments.agent.empty()) {
    ASSIGN_OR_RETURN(const std::string secret, arguments.agent_secret());
    return serve_as_agent(arguments.agent, secret, arguments.agent_for_anyone);
  }
  if (arguments.agents.empty() && !arguments.agent_token_file.empty()) {
    return absl::InvalidArgumentError("--agent-token-file needs --agents or --agent");
  }
  StagedOutput output;
  RETURN_IF_ERROR(announce(arguments, output));
  BenchSummary summary;
  summary.server = arguments.server.address();
  ASSIGN_OR_RETURN(summary.objectives, arguments.parsed_objectives());
  RETURN_IF_ERROR(arguments.plan().status());
  ASSIGN_OR_RETURN(const auto source, frame_source(arguments));
  ASSIGN_OR_RETURN(const auto client, arguments.server.connect());
  ASSIGN_OR_RETURN(const auto info, client.server_info());  // Without a server there is nothing to measure.
  summary.server_info = server_info_json(info);
  for (const bench::Encoding& encoding : source.encodings) summary.codecs.push_back(encoding.name);

  std::string hdr_log;
  RETURN_IF_ERROR(measure(arguments, source, summary, hdr_log));
  const nlohmann::ordered_json json = to_json(summary);
  arguments.json.add(output, json);
  RETURN_IF_ERROR(arguments.html.add(output, json));
  if (!arguments.csv.empty()) output.add(arguments.csv, bench_csv(summary.result.timeline));
  if (!arguments.hdr_log.empty()) output.add(arguments.hdr_log, std::move(hdr_log));
  if (!output.uses_stdout()) output.add("-", to_text(summary));
  RETURN_IF_ERROR(output.commit());
  return verdict(summary);
}

}  // namespace

void add_bench_command(CLI::App& app, Command& chosen) {
  add_command(app, chosen, "bench", "Load a server, and measure latency and throughput", help(), run);
}

}  // namespace segserve::segctl
