// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/option_flags.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "fmt/format.h"

namespace segserve::segctl {
namespace {

std::string flag_name(std::string_view option) {
  std::string name = "--" + std::string(option);
  std::ranges::replace(name, '_', '-');
  return name;
}

/// "auto" for the parser of numbers. No option takes it as a number.
constexpr const char* kAuto = "nan";

/// Whether the default method lets the cloud choose the value of an option that is unset.
bool chosen_by_cloud(const OptionInfo& option) {
  return option.name == "voxel_resolution" || option.name == "seed_resolution";
}

/// The default of the default method. It says so if the paper's methods have other defaults.
std::string default_text(const OptionInfo& option) {
  const std::optional<double> ours = default_value(option, Options{}.method);
  if (chosen_by_cloud(option)) return fmt::format(", default auto for {}", name(Options{}.method));
  if (!ours) return "";
  const bool same = std::ranges::all_of(all_methods(), [&](Method m) { return default_value(option, m) == ours; });
  return fmt::format(", default {}{}", *ours, same ? "" : fmt::format(" for {}", name(Options{}.method)));
}

std::string help_text(const OptionInfo& option) {
  return fmt::format("{}; {} to {}{}{}{}", option.description, option.minimum, option.maximum,
                     option.unit.empty() ? "" : " ", option.unit, default_text(option));
}

}  // namespace

void OptionFlags::add_number(CLI::App& app, const OptionInfo& option, Flag& flag) {
  flag.option = &option;
  CLI::Option* added = app.add_option(flag_name(option.name), flag.value, help_text(option))
                           ->type_name(option.whole ? "INT" : "NUMBER")
                           ->group("Segmentation");
  // "auto" is what is meant without the flag.
  if (!chosen_by_cloud(option)) return;
  added->type_name("NUMBER|auto")->transform([](const std::string& text) {
    if (text == "auto") return std::string(kAuto);
    return text == kAuto ? std::string("no number") : text;
  });
}

void OptionFlags::add_to(CLI::App& app) {
  app.add_option("--method", method_,
                 fmt::format("how the dissimilarity of two regions is measured: {}; default {}", method_names(),
                             name(Options{}.method)))
      ->type_name("NAME")
      ->group("Segmentation");
  app.add_option("--preset", preset_,
                 fmt::format("what kind of cloud it is: {}; default auto, the cloud tells", preset_names()))
      ->type_name("NAME")
      ->group("Segmentation");
  flags_.resize(option_table().size());  // No reallocation may follow: the parser keeps addresses of the flags.
  for (std::size_t i = 0; i < flags_.size(); ++i) add_number(app, option_table()[i], flags_[i]);
}

void OptionFlags::add_cut_to(CLI::App& app) {
  flags_.resize(2);
  auto flag = flags_.begin();
  for (const OptionInfo& info : option_table()) {
    if (info.name == "threshold" || info.name == "regions") add_number(app, info, *flag++);
  }
}

absl::StatusOr<Options> OptionFlags::options() const {
  Options options;
  std::vector<FieldViolation> faults;
  if (!method_.empty()) {
    if (const auto method = method_from_name(method_)) {
      options.method = *method;
    } else {
      faults.push_back({"method", fmt::format("'{}' is not one of {}", method_, method_names())});
    }
  }
  if (!preset_.empty()) {
    if (const auto preset = preset_from_name(preset_)) {
      options.preset = *preset;
    } else {
      faults.push_back({"preset", fmt::format("'{}' is not one of {}", preset_, preset_names())});
    }
  }
  for (const Flag& flag : flags_) {
    if (!flag.value || (chosen_by_cloud(*flag.option) && std::isnan(*flag.value))) continue;
    if (auto fault = violation(*flag.option, *flag.value)) {
      faults.push_back(*std::move(fault));
    } else {
      flag.option->set(options, *flag.value);
    }
  }
  std::ranges::move(violations(options), std::back_inserter(faults));
  if (faults.empty()) return options;
  std::string message;
  for (const FieldViolation& fault : faults) {
    message += fmt::format("{}{}: {}", message.empty() ? "" : "; ", fault.field, fault.description);
  }
  return absl::InvalidArgumentError(message);
}

}  // namespace segserve::segctl
