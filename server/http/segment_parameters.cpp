// SPDX-License-Identifier: Apache-2.0
#include "server/http/segment_parameters.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <utility>
#include <vector>

#include "command_line/closest_name.hpp"
#include "core/base/status_text.hpp"
#include "fmt/format.h"
#include "proto/text/number_list.hpp"
#include "proto/text/prompt_text.hpp"
#include "proto/text/view_text.hpp"
#include "proto/wire/prompts_message.hpp"
#include "proto/wire/status_message.hpp"
#include "segserve/codec/length_unit.hpp"
#include "server/http/request_query.hpp"

namespace segserve::server {
namespace {

constexpr std::size_t kMostParameters = 256, kMostTextBytes = 256;
constexpr double kMostSeconds = 86'400;

/// The parameters that are no options of the method.
constexpr std::array<std::string_view, 14> kOtherParameters{
    "method", "preset",     "outputs",        "include",     "exclude", "larger",     "view",
    "unit",   "intrinsics", "rgb_intrinsics", "depth_scale", "timeout", "request_id", "name"};

std::vector<std::string> parameter_names() {
  std::vector<std::string> names(kOtherParameters.begin(), kOtherParameters.end());
  for (const OptionInfo& option : option_table()) names.emplace_back(option.name);
  return names;
}

std::string unknown_parameter(const std::string& name) {
  const auto meant = closest_name(name, parameter_names());
  return meant ? fmt::format("is no parameter (did you mean {}?)", *meant) : "is no parameter";
}

/// Collects what the parameters say, and their faults.
class Reader {
 public:
  explicit Reader(const Options& defaults) { parameters_.request.options = defaults; }

  void read(const std::string& name, const std::string& value);
  absl::StatusOr<SegmentParameters> finish() &&;

 private:
  void fault(const std::string& name, std::string text) { faults_.push_back({name, std::move(text)}); }
  bool read_option(const std::string& name, const std::string& value);
  void read_outputs(const std::string& value);
  void read_prompt(const std::string& name, const std::string& value, std::vector<Prompt>& prompts);
  void read_camera(const std::string& name, const std::string& value, std::optional<codec::Intrinsics>& camera);
  void read_text(const std::string& name, const std::string& value, std::string& text);
  template <typename Number>
  std::optional<Number> number(const std::string& name, const std::string& value);
  Prompts& prompts() {
    auto& prompts = parameters_.request.prompts;
    return prompts ? *prompts : prompts.emplace();
  }

  SegmentParameters parameters_{.request = {.options = {}, .outputs = {.labels = false}}, .read = {}};
  std::vector<FieldViolation> faults_;
  std::set<std::string> given_;
};

template <typename Number>
std::optional<Number> Reader::number(const std::string& name, const std::string& value) {
  const auto numbers = text::parse_numbers<Number, 1>(value);
  if (numbers) return numbers->front();
  fault(name, fmt::format("'{}' is no number", value));
  return std::nullopt;
}

bool Reader::read_option(const std::string& name, const std::string& value) {
  const auto table = option_table();
  const auto option = std::ranges::find(table, name, &OptionInfo::name);
  if (option == table.end()) return false;
  const auto given = number<double>(name, value);
  if (!given) return true;
  if (auto wrong = violation(*option, *given)) {
    faults_.push_back(*std::move(wrong));
    return true;
  }
  Options& options = parameters_.request.options;
  // A cut that is given goes before that of the server's defaults, whichever kind that is.
  if (name == "threshold" && !given_.contains("regions")) options.regions.reset();
  if (name == "regions" && !given_.contains("threshold")) options.threshold.reset();
  option->set(options, *given);
  return true;
}

void Reader::read_outputs(const std::string& value) {
  wire::Outputs& outputs = parameters_.request.outputs;
  for (std::size_t begin = 0; begin <= value.size();) {
    const std::size_t end = std::min(value.find(',', begin), value.size());
    const std::string name = value.substr(begin, end - begin);
    begin = end + 1;
    if (name == "labels") {
      outputs.labels = true;
    } else if (name == "supervoxels") {
      outputs.supervoxels = true;
    } else if (name == "tree") {
      outputs.tree = true;
    } else if (name == "segments") {
      outputs.segments = true;
    } else {
      fault("outputs", fmt::format("'{}' is not one of labels, supervoxels, tree, segments", name));
    }
  }
}

void Reader::read_prompt(const std::string& name, const std::string& value, std::vector<Prompt>& prompts) {
  auto prompt = text::parse_prompt(value);
  if (prompt.ok()) {
    prompts.push_back(*std::move(prompt));
  } else {
    fault(name, message_of(prompt.status()));
  }
}

void Reader::read_camera(const std::string& name, const std::string& value, std::optional<codec::Intrinsics>& camera) {
  const auto numbers = text::parse_numbers<double, 4>(value);
  if (!numbers) return fault(name, fmt::format("'{}' is not FX,FY,CX,CY, four numbers in pixels", value));
  const codec::Intrinsics read{(*numbers)[0], (*numbers)[1], (*numbers)[2], (*numbers)[3]};
  if (const absl::Status status = codec::check_intrinsics(read); !status.ok()) return fault(name, message_of(status));
  camera = read;
}

void Reader::read_text(const std::string& name, const std::string& value, std::string& text) {
  if (value.size() > kMostTextBytes) {
    return fault(name, fmt::format("has {} bytes, but may have at most {}", value.size(), kMostTextBytes));
  }
  text = value;
}

void Reader::read(const std::string& name, const std::string& value) {
  const bool may_repeat = name == "include" || name == "exclude" || name == "outputs";
  if (!may_repeat && given_.contains(name)) return fault(name, "is given twice");
  if (read_option(name, value)) {
    // It is read, or a fault is told.
  } else if (name == "method") {
    if (const auto method = method_from_name(value)) {
      parameters_.request.options.method = *method;
    } else {
      fault(name, fmt::format("'{}' is not one of {}", value, method_names()));
    }
  } else if (name == "preset") {
    if (const auto preset = preset_from_name(value)) {
      parameters_.request.options.preset = *preset;
    } else {
      fault(name, fmt::format("'{}' is not one of {}", value, preset_names()));
    }
  } else if (name == "outputs") {
    read_outputs(value);
  } else if (name == "include") {
    read_prompt(name, value, prompts().include);
  } else if (name == "exclude") {
    read_prompt(name, value, prompts().exclude);
  } else if (name == "larger") {
    prompts().larger = number<std::int32_t>(name, value).value_or(0);
  } else if (name == "view") {
    parameters_.read.view = text::parse_view(value);
    if (!parameters_.read.view) fault(name, fmt::format("'{}' must be {}", value, text::kViewRule));
  } else if (name == "unit") {
    const auto unit = codec::length_unit_from_name(value);
    if (!unit) fault(name, fmt::format("'{}' is not one of m, cm, mm, in, ft, auto", value));
    parameters_.read.unit = unit.value_or(codec::LengthUnit::kMeter);
  } else if (name == "intrinsics") {
    read_camera(name, value, parameters_.intrinsics);
  } else if (name == "rgb_intrinsics") {
    read_camera(name, value, parameters_.color_intrinsics);
  } else if (name == "depth_scale") {
    parameters_.depth_scale = number<double>(name, value);
    const absl::Status status = codec::check_depth_scale(parameters_.depth_scale.value_or(1));
    if (!status.ok()) fault(name, message_of(status));
  } else if (name == "timeout") {
    const double seconds = number<double>(name, value).value_or(kMostSeconds);
    if (!(seconds > 0 && seconds <= kMostSeconds)) {
      fault(name, fmt::format("{} s is not above 0 and at most {}", seconds, kMostSeconds));
    } else {
      parameters_.timeout = std::chrono::milliseconds(static_cast<std::int64_t>(seconds * 1000) + 1);
    }
  } else if (name == "request_id") {
    read_text(name, value, parameters_.request_id);
  } else if (name == "name") {
    read_text(name, value, parameters_.name);
  } else {
    fault(name.substr(0, kMostTextBytes), unknown_parameter(name));
  }
  given_.insert(name);
}

absl::StatusOr<SegmentParameters> Reader::finish() && {
  // A parameter that was left out because of a fault may seem to cause other faults, which would mislead.
  const auto add = [this](std::vector<FieldViolation> found) {
    for (FieldViolation& wrong : found) {
      const bool is_known = std::ranges::find(faults_, wrong.field, &FieldViolation::field) != faults_.end();
      if (!is_known) faults_.push_back(std::move(wrong));
    }
  };
  add(violations(parameters_.request.options));
  if (parameters_.request.prompts) add(violations(*parameters_.request.prompts));
  if (absl::Status status = wire::invalid_fields(faults_); !status.ok()) return status;
  return std::move(parameters_);
}

}  // namespace

bool is_segment_parameter(std::string_view name) {
  return std::ranges::find(kOtherParameters, name) != kOtherParameters.end() ||
         std::ranges::find(option_table(), name, &OptionInfo::name) != option_table().end();
}

absl::StatusOr<SegmentParameters> parse_segment_parameters(std::string_view query, const Options& defaults) {
  const auto parameters = parse_query(query);
  if (!parameters) return wire::invalid_fields({{"query", "has an escape that is not % and two hexadecimal digits"}});
  if (parameters->size() > kMostParameters) {
    return wire::invalid_fields({{"query", fmt::format("has more than {} parameters", kMostParameters)}});
  }
  Reader reader(defaults);
  for (const auto& [name, value] : *parameters) reader.read(name, value);
  return std::move(reader).finish();
}

}  // namespace segserve::server
