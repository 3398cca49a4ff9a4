// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/command.hpp"
#include "client/segctl/json_flag.hpp"
#include "client/segctl/server_flags.hpp"
#include "client/segctl/staged_output.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "fmt/format.h"
#include "nlohmann/json.hpp"

namespace segserve::segctl {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDefaultTimeout = 2;

HelpText help() {
  return {.common = {"--server", "--timeout", "--json", "--quiet"},
          .examples = R"(segctl health
segctl health --server robot:50051 --timeout 0.5 && echo ready)",
          .details = "The question is that of grpc.health.v1. The JSON is written in every case that is not bad usage.",
          .exit_codes = "0 the server serves; 1 it does not serve, or cannot be reached; 2 bad usage."};
}

struct HealthArguments {
  ServerFlags server;
  JsonFlag json;
  bool quiet = false;

  void add_to(CLI::App& app) {
    server.add_to(app, kDefaultTimeout);
    json.add_to(app, "write the answer as one JSON object");
    app.add_flag("-q,--quiet", quiet, "print no text: only the exit code tells")->group("Output");
  }
};

absl::Status run(const HealthArguments& arguments) {
  StagedOutput output;
  RETURN_IF_ERROR(arguments.json.announce(output));
  ASSIGN_OR_RETURN(const auto client, arguments.server.connect());
  const absl::Status health = client.health();
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
