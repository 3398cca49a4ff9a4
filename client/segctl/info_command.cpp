// SPDX-License-Identifier: Apache-2.0
#include <string>

#include "client/segctl/command.hpp"
#include "client/segctl/file_info.hpp"
#include "client/segctl/json_flag.hpp"
#include "client/segctl/recording_flags.hpp"
#include "client/segctl/server_flags.hpp"
#include "client/segctl/server_info_json.hpp"
#include "client/segctl/staged_output.hpp"
#include "client/segctl/unit_flag.hpp"
#include "client/segctl/view_flag.hpp"
#include "core/base/status_macros.hpp"
#include "fmt/format.h"
#include "nlohmann/json.hpp"
#include "segserve/v1/segmentation_service.pb.h"

namespace segserve::segctl {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDefaultTimeout = 5;

HelpText help() {
  return {.common = {"--server", "--timeout", "--unit", "--view", "--json"},
          .examples = R"(segctl info
segctl info --server robot:50051 --json - | jq .limits.max_points
segctl info scan.ply)",
          .details = "With FILE it tells what is in a file, asks no server, and segments nothing.",
          .exit_codes = "0 success; 1 the operation failed (server unreachable); 2 bad input or usage."};
}

struct InfoArguments {
  std::string file;
  std::string view;
  UnitFlag unit;
  ServerFlags server;
  JsonFlag json;

  void add_to(CLI::App& app) {
    app.add_option("FILE", file,
                   "tell what is in the file of a cloud, or the topics of a recording; - is standard input; default: "
                   "the server")
        ->type_name("FILE");
    unit.add_to(app, "File");
    app.add_option("--view", view, "where the sensor is: camera, world, or world:X,Y,Z with its position in meters")
        ->type_name("VIEW")
        ->group("File");
    server.add_to(app, kDefaultTimeout);
    json.add_to(app, "write one JSON object instead of text");
  }
};

/// "0.008 m", or "auto" where the cloud decides.
std::string resolution_text(const Json& resolution) { return resolution.is_null() ? "auto" : resolution.dump() + " m"; }

std::string to_text(const Json& json, const std::string& address) {
  const auto words = [](const Json& list) {
    std::string text;
    for (const Json& word : list) text += (text.empty() ? "" : ", ") + word.get<std::string>();
    return text;
  };
  std::string text = fmt::format("{}: segserve {}\n", address, json["version"].get<std::string>());
  text += fmt::format("payloads: {}; compressions: {}\n", words(json["payload_kinds"]), words(json["compressions"]));
  text += "codecs:\n";
  for (const Json& codec : json["codecs"]) {
    text += fmt::format("  {:<18} {}\n", codec["name"].get<std::string>(), codec["description"].get<std::string>());
  }
  text += "limits:\n";
  for (const auto& [name, value] : json["limits"].items()) text += fmt::format("  {:<18} {}\n", name, value.dump());
  text += fmt::format("methods (default {}):\n", json["default_method"].get<std::string>());
  for (const Json& method : json["methods"]) {
    text += fmt::format("  {:<20} threshold {}, voxels {}, seeds {}\n", method["name"].get<std::string>(),
                        method["default_threshold"].dump(), resolution_text(method["default_voxel_resolution"]),
                        resolution_text(method["default_seed_resolution"]));
  }
  text += "options:\n";
  for (const Json& option : json["options"]) {
    const std::string unit = option["unit"].get<std::string>();
    const std::string standard = option["default"].is_null() ? "" : ", default " + option["default"].dump();
    text += fmt::format("  {:<22} {} to {}{}{}{}\n", option["name"].get<std::string>(), option["minimum"].get<double>(),
                        option["maximum"].get<double>(), unit.empty() ? "" : " ", unit, standard);
  }
  return text;
}

absl::StatusOr<Json> info_of_file(const InfoArguments& arguments) {
  if (arguments.server.server_given()) {
    return absl::InvalidArgumentError("FILE and --server exclude each other: a file is read without a server");
  }
  if (is_recording_file(arguments.file)) return recording_info(arguments.file);
  codec::ReadOptions options{.unit = arguments.unit.unit()};
  if (!arguments.view.empty()) {
    ASSIGN_OR_RETURN(options.view, parse_view(arguments.view));
  }
  return file_info(arguments.file, options);
}

absl::StatusOr<Json> info_of_server(const InfoArguments& arguments) {
  if (!arguments.view.empty() || arguments.unit.given()) {
    return absl::InvalidArgumentError("--view and --unit need FILE");
  }
  ASSIGN_OR_RETURN(const auto client, arguments.server.connect());
  ASSIGN_OR_RETURN(const auto info, client.server_info());
  return server_info_json(info);
}

absl::Status run(const InfoArguments& arguments) {
  StagedOutput output;
  if (!arguments.file.empty()) RETURN_IF_ERROR(output.protect({arguments.file}, true));
  RETURN_IF_ERROR(arguments.json.announce(output));
  const bool is_file = !arguments.file.empty();
  ASSIGN_OR_RETURN(const Json json, is_file ? info_of_file(arguments) : info_of_server(arguments));
  constexpr int kIndent = 2;
  if (arguments.json.given()) {
    arguments.json.add(output, json_text(json, kIndent));
  } else {
    output.add("-", json.contains("topics") ? recording_info_text(json)
                    : is_file               ? file_info_text(json)
                                            : to_text(json, arguments.server.address()));
  }
  return output.commit();
}

}  // namespace

void add_info_command(CLI::App& app, Command& chosen) {
  add_command(app, chosen, "info", "Tell what the server can do, or what is in a file", help(), run);
}

}  // namespace segserve::segctl
