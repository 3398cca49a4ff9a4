// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <optional>
#include <string>
#include <thread>

#include "client/segctl/command.hpp"
#include "client/segctl/json_flag.hpp"
#include "client/segctl/server_flags.hpp"
#include "client/segctl/staged_output.hpp"
#include "command_line/number_range.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "fmt/format.h"
#include "nlohmann/json.hpp"

namespace segserve::segctl {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDefaultTimeout = 2;
constexpr std::chrono::milliseconds kPause{100};  // between two questions

HelpText help() {
  return {.common = {"--server", "--timeout", "--service", "--wait", "--json", "--quiet"},
          .examples = R"(segctl health
segctl health --server robot:50051 --timeout 0.5 && echo ready
segctl health --wait 10
segctl health --service liveness)",
          .details = "The question is that of grpc.health.v1. The JSON is written in every case that is not bad usage.",
          .exit_codes = "0 the server serves; 1 it does not serve, or cannot be reached; 2 bad usage."};
}

struct HealthArguments {
  ServerFlags server;
  JsonFlag json;
  std::string service;
  double wait_seconds = 0;
  bool quiet = false;

  void add_to(CLI::App& app) {
    server.add_to(app, kDefaultTimeout);
    app.add_option("--service", service,
                   "readiness, which is the default, or liveness, which a server that is about to stop still has")
        ->type_name("NAME");
    app.add_option("--wait", wait_seconds,
                   "ask again for so many seconds until the server serves, e.g. while it starts")
        ->type_name("SECONDS")
        ->check(seconds_range(0, 86'400));
    json.add_to(app, "write the answer as one JSON object");
    app.add_flag("-q,--quiet", quiet, "print no text: only the exit code tells")->group("Output");
  }
};

absl::Status run(const HealthArguments& arguments) {
  StagedOutput output;
  RETURN_IF_ERROR(arguments.json.announce(output));
  ASSIGN_OR_RETURN(const auto client, arguments.server.connect());
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(arguments.wait_seconds);
  absl::Status health = client.health(std::nullopt, arguments.service);
  const auto may_change = [&health] { return absl::IsUnavailable(health) || absl::IsDeadlineExceeded(health); };
  while (may_change() && std::chrono::steady_clock::now() + kPause < end) {
    std::this_thread::sleep_for(kPause);
    health = client.health(std::nullopt, arguments.service);
  }
  arguments.json.add(output, Json{{"server", arguments.server.address()},
                                  {"serving", health.ok()},
                                  {"error", health.ok() ? Json() : Json(message_of(health))}});
  if (health.ok() && !arguments.quiet && !output.uses_stdout()) {
    output.add("-", fmt::format("{} is SERVING\n", arguments.server.address()));
  }
  RETURN_IF_ERROR(output.commit());
  return health;
}

}  // namespace

void add_health_command(CLI::App& app, Command& chosen) {
  add_command(app, chosen, "health", "Ask whether the server serves, e.g. in a container's HEALTHCHECK", help(), run);
}

}  // namespace segserve::segctl
