#include <memory>

#include "client/segctl/command.hpp"
#include "client/segctl/server_flags.hpp"
#include "client/segctl/staged_output.hpp"
#include "fmt/format.h"

namespace segserve::segctl {
namespace {

constexpr double kDefaultTimeout = 2;

constexpr const char* kFooter = R"(Examples:
  segctl health
  segctl health --server robot:50051 --timeout 0.5 && echo ready

Exit codes: 0 the server serves (grpc.health.v1 SERVING); 1 it does not, or cannot be reached;
2 bad usage.)";

struct Arguments {
  ServerFlags server;
  bool quiet = false;
};

absl::Status run(const Arguments& arguments) {
  const auto client = arguments.server.connect();
  if (!client.ok()) return client.status();
  if (absl::Status status = client->health(); !status.ok()) return status;
  StagedOutput output;
  if (!arguments.quiet) output.add("-", fmt::format("{} is SERVING\n", arguments.server.address()));
  return output.commit();
}

}  // namespace

void add_health_command(CLI::App& app, Command& chosen) {
  CLI::App* command = app.add_subcommand("health", "Ask whether the server serves; made for HEALTHCHECK");
  auto arguments = std::make_shared<Arguments>();
  arguments->server.add_to(*command, kDefaultTimeout);
  command->add_flag("-q,--quiet", arguments->quiet, "only the exit code tells");
  command->footer(kFooter);
  command->callback([arguments, &chosen] { chosen = [arguments] { return run(*arguments); }; });
}

}  // namespace segserve::segctl
