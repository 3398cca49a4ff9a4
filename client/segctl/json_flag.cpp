// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/json_flag.hpp"

#include <utility>

#include "client/segctl/output_kind.hpp"
#include "nlohmann/json.hpp"

namespace segserve::segctl {

using Json = nlohmann::ordered_json;

std::string json_text(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace) + "\n";
}

void JsonFlag::add_to(CLI::App& app, const std::string& help) {
  app.add_option("--json", path_, help + "; - is standard output")->type_name("FILE")->group("Output");
}

absl::Status JsonFlag::announce(StagedOutput& output) const {
  if (!given()) return absl::OkStatus();
  RETURN_IF_ERROR(output.announce(path_));
  return check_output_name("--json", path_, OutputKind::kJson);
}

void JsonFlag::add(StagedOutput& output, std::string text) const {
  if (given()) output.add(path_, std::move(text));
}

void JsonFlag::add(StagedOutput& output, const Json& json) const { add(output, json_text(json)); }

}  // namespace segserve::segctl
