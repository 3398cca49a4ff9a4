#include "segserve/segctl/option_flags.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "fmt/format.h"

namespace segserve::segctl {
namespace {

/// Where an option of `option_table()` is kept in Options.
struct Place {
  std::string_view name;
  bool whole;  ///< takes whole numbers only
  void (*set)(Options&, double);
};

constexpr std::array kPlaces = {
    Place{"voxel_resolution", false, [](Options& o, double v) { o.voxel_resolution = v; }},
    Place{"seed_resolution", false, [](Options& o, double v) { o.seed_resolution = v; }},
    Place{"color_weight", false, [](Options& o, double v) { o.weights.color = v; }},
    Place{"spatial_weight", false, [](Options& o, double v) { o.weights.spatial = v; }},
    Place{"normal_weight", false, [](Options& o, double v) { o.weights.normal = v; }},
    Place{"lambda", false, [](Options& o, double v) { o.lambda = v; }},
    Place{"threshold", false, [](Options& o, double v) { o.threshold = v; }},
    Place{"regions", true, [](Options& o, double v) { o.regions = static_cast<std::uint32_t>(v); }},
    Place{"threads", true, [](Options& o, double v) { o.threads = static_cast<std::uint32_t>(v); }},
};

const Place* find_place(std::string_view name) {
  const auto* place = std::ranges::find(kPlaces, name, &Place::name);
  return place == kPlaces.end() ? nullptr : place;
}

std::string flag_name(std::string_view option) {
  std::string name = "--" + std::string(option);
  std::ranges::replace(name, '_', '-');
  return name;
}

std::string help_text(const OptionInfo& info) {
  std::string text = fmt::format("{}; {} to {}", info.description, info.minimum, info.maximum);
  if (!info.unit.empty()) text += fmt::format(" {}", info.unit);
  if (info.default_value) text += fmt::format(", default {}", *info.default_value);
  return text;
}

std::string method_names() {
  std::string names;
  for (const Method method : all_methods()) {
    names += fmt::format("{}{}", names.empty() ? "" : ", ", name(method));
  }
  return names;
}

/// Stores a value, unless it is not a whole number where one is needed: a cast would hide that.
std::optional<FieldViolation> set_value(Options& options, std::string_view name, double value) {
  const Place& place = *find_place(name);
  const auto info = std::ranges::find(option_table(), name, &OptionInfo::name);
  const bool in_range = value >= info->minimum && value <= info->maximum;
  if (place.whole && (!in_range || value != std::floor(value))) {
    return FieldViolation{std::string(name),
                          fmt::format("{} is not a whole number in [{}, {}]", value, info->minimum, info->maximum)};
  }
  place.set(options, value);
  return std::nullopt;
}

}  // namespace

void OptionFlags::add_number(CLI::App& app, const OptionInfo& info, Flag& flag) {
  flag.name = info.name;
  app.add_option(flag_name(info.name), flag.value, help_text(info))
      ->type_name(find_place(info.name)->whole ? "INT" : "NUMBER")
      ->group("Segmentation");
}

void OptionFlags::add_to(CLI::App& app) {
  app.add_option("--method", method_,
                 fmt::format("dissimilarity by which regions are merged: {}; default {}", method_names(),
                             name(Options{}.method)))
      ->type_name("NAME")
      ->group("Segmentation");
  flags_.resize(option_table().size());  // before their addresses are taken
  for (std::size_t i = 0; i < flags_.size(); ++i) {
    if (find_place(option_table()[i].name) != nullptr) add_number(app, option_table()[i], flags_[i]);
  }
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
      faults.push_back({"method", fmt::format("'{}' is none of {}", method_, method_names())});
    }
  }
  for (const Flag& flag : flags_) {
    if (!flag.value) continue;
    if (auto fault = set_value(options, flag.name, *flag.value)) faults.push_back(*std::move(fault));
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
