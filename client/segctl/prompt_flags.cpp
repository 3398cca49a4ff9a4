// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/prompt_flags.hpp"

#include <limits>

#include "core/base/status_macros.hpp"
#include "fmt/format.h"
#include "proto/text/prompt_text.hpp"

namespace segserve::segctl {

void PromptFlags::add_to(CLI::App& app, bool required) {
  const auto add_places = [&app](const char* flag, std::vector<std::string>& places, const char* help) {
    return app.add_option(flag, places, help)->type_name("PLACE")->allow_extra_args(false)->group("Places");
  };
  const auto add_steps = [&app](const char* flag, std::int32_t& steps, const char* help) {
    app.add_option(flag, steps, help)
        ->type_name("INT")
        ->check(CLI::Range(0, std::numeric_limits<std::int32_t>::max()))
        ->group("Places");
  };
  add_places("--include", include_, "a place that is picked: X,Y,Z or a pixel U,V; may be repeated")
      ->required(required);
  add_places("--exclude", exclude_, "a place that is not picked; may be repeated");
  add_steps("--larger", larger_, "take the choice that is larger by so many steps");
  add_steps("--smaller", smaller_, "take the choice that is smaller by so many steps");
}

absl::StatusOr<Prompts> PromptFlags::prompts() const {
  Prompts prompts{.include = {}, .exclude = {}, .larger = larger_ - smaller_};
  for (const std::string& place : include_) {
    ASSIGN_OR_RETURN(prompts.include.emplace_back(), text::parse_prompt(place));
  }
  for (const std::string& place : exclude_) {
    ASSIGN_OR_RETURN(prompts.exclude.emplace_back(), text::parse_prompt(place));
  }
  std::string message;
  for (const FieldViolation& fault : violations(prompts)) {
    message += fmt::format("{}--{} {}", message.empty() ? "" : "; ", fault.field, fault.description);
  }
  if (!message.empty()) return absl::InvalidArgumentError(message);
  return prompts;
}

}  // namespace segserve::segctl
