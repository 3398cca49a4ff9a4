// SPDX-License-Identifier: Apache-2.0
#include "client/ros/core/node_options.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <functional>
#include <string_view>
#include <system_error>
#include <utility>

#include "fmt/format.h"
#include "proto/text/view_text.hpp"

namespace segserve::ros {
namespace {

/// Sets an option from text. Returns what the text must be, or nothing if it is that.
using Setter = std::function<std::string(std::string_view text, NodeOptions& options)>;

struct Parameter {
  ParameterInfo info;
  Setter set;
};

std::optional<double> number_of(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// A number in a closed range.
template <typename Assign>
Setter number(double low, double high, bool whole, Assign assign) {
  return [=](std::string_view text, NodeOptions& options) -> std::string {
    const auto value = number_of(text);
    if (!value || *value < low || *value > high || (whole && std::floor(*value) != *value)) {
      return fmt::format("must be a {}number from {} to {}", whole ? "whole " : "", low, high);
    }
    assign(options, *value);
    return {};
  };
}

template <typename Assign>
Setter flag(Assign assign) {
  return [=](std::string_view text, NodeOptions& options) -> std::string {
    if (text != "true" && text != "false") return "must be true or false";
    assign(options, text == "true");
    return {};
  };
}

template <typename Assign>
Setter words(Assign assign) {
  return [=](std::string_view text, NodeOptions& options) -> std::string {
    assign(options, std::string(text));
    return {};
  };
}

client::TlsOptions& tls_of(NodeOptions& options) {
  return options.client.tls ? *options.client.tls : options.client.tls.emplace();
}

std::string set_view(std::string_view text, NodeOptions& options) {
  options.view = text::parse_view(text);
  return options.view ? "" : fmt::format("must be {}", text::kViewRule);
}

std::string set_method(std::string_view text, NodeOptions& options) {
  const auto method = method_from_name(text);
  if (method) {
    options.segmentation.method = *method;
    return {};
  }
  return fmt::format("must be one of {}", method_names());
}

std::string set_preset(std::string_view text, NodeOptions& options) {
  const auto preset = preset_from_name(text);
  if (preset) options.segmentation.preset = *preset;
  return preset ? "" : fmt::format("must be one of {}", preset_names());
}

Setter segmentation_setter(const OptionInfo& option) {
  return [&option](std::string_view text, NodeOptions& options) -> std::string {
    const auto value = number_of(text);
    if (!value) return "must be a number";
    if (auto fault = violation(option, *value)) return fault->description;
    option.set(options.segmentation, *value);
    return {};
  };
}

std::chrono::milliseconds milliseconds_of(double seconds) {
  return std::chrono::milliseconds(static_cast<std::int64_t>(std::lround(1000 * seconds)));
}

std::vector<Parameter> connection_parameters() {
  return {
      {{"address", "", "127.0.0.1:50051", "the servers, as host:port, with commas between several"},
       words([](NodeOptions& o, std::string text) { o.client.address = std::move(text); })},
      {{"token_file", "", "", "a file with the token that the servers ask for"},
       words([](NodeOptions& o, std::string text) { o.client.token_file = std::move(text); })},
      {{"tls", "", "false", "whether the connections are encrypted; also if tls_ca or tls_cert is set"},
       flag([](NodeOptions& o, bool on) {
         if (on) tls_of(o);
       })},
      {{"tls_ca", "", "", "a PEM file with the authorities that may have signed the servers' certificates"},
       words([](NodeOptions& o, std::string text) { tls_of(o).ca_file = std::move(text); })},
      {{"tls_cert", "", "", "a PEM file with the certificate that this node shows; needs tls_key"},
       words([](NodeOptions& o, std::string text) { tls_of(o).cert_file = std::move(text); })},
      {{"tls_key", "", "", "a PEM file with the key of that certificate"},
       words([](NodeOptions& o, std::string text) { tls_of(o).key_file = std::move(text); })},
      {{"fallback_to_local", "", "false", "segment in this process when no server is in reach"},
       flag([](NodeOptions& o, bool on) { o.fallback_to_local = on; })},
  };
}

std::vector<Parameter> frame_parameters() {
  return {
      {{"view", "", "",
        "where the sensor is: camera, world or world:X,Y,Z in meters; unset: the frame and points tell"},
       set_view},
      {{"time_to_live", "s", "0.5", "a result that is older is of no use; 0: it never is too old"},
       number(0, 3600, false,
              [](NodeOptions& o, double value) {
                o.time_to_live = value > 0 ? std::optional(milliseconds_of(value)) : std::nullopt;
              })},
      {{"max_in_flight", "", "2", "clouds at the servers at the same time; of those that wait only the newest is kept"},
       number(1, 1024, true, [](NodeOptions& o, double value) { o.max_in_flight = static_cast<std::size_t>(value); })},
      {{"track", "", "false", "objects keep their ids from cloud to cloud: labels are ids"},
       flag([](NodeOptions& o, bool on) { o.track = on; })},
      {{"min_points", "points", "50", "smaller segments are labeled, but are no detections"},
       number(1, 2147483647, true,
              [](NodeOptions& o, double value) { o.min_points = static_cast<std::uint32_t>(value); })},
      {{"method", "", std::string(name(Method::kBorder)), "how the dissimilarity of two regions is measured"},
       set_method},
      {{"preset", "", "auto", fmt::format("what kind of cloud it is: {}", preset_names())}, set_preset},
  };
}

std::vector<Parameter> parameters() {
  std::vector<Parameter> all = connection_parameters();
  for (Parameter& parameter : frame_parameters()) all.push_back(std::move(parameter));
  for (const OptionInfo& option : option_table()) {
    ParameterInfo info{std::string(option.name), std::string(option.unit), "", std::string(option.description)};
    all.push_back({std::move(info), segmentation_setter(option)});
  }
  return all;
}

}  // namespace

std::vector<ParameterInfo> parameter_table() {
  std::vector<ParameterInfo> table;
  for (Parameter& parameter : parameters()) table.push_back(std::move(parameter.info));
  return table;
}

absl::StatusOr<NodeOptions> parse_parameters(const std::map<std::string, std::string>& values) {
  NodeOptions options;
  std::string faults;
  const auto fault = [&](std::string_view name, std::string_view text) {
    faults += fmt::format("{}{}: {}", faults.empty() ? "" : "; ", name, text);
  };
  const std::vector<Parameter> known = parameters();
  std::size_t found = 0;
  for (const Parameter& parameter : known) {
    const auto value = values.find(parameter.info.name);
    if (value == values.end()) continue;
    ++found;
    if (value->second.empty()) continue;
    if (const std::string rule = parameter.set(value->second, options); !rule.empty()) {
      fault(parameter.info.name, fmt::format("'{}' {}", value->second, rule));
    }
  }
  if (found != values.size()) {
    for (const auto& [name, value] : values) {
      bool is_known = false;
      for (const Parameter& parameter : known) is_known = is_known || parameter.info.name == name;
      if (!is_known) fault(name, "there is no such parameter");
    }
  }
  for (const FieldViolation& violation : violations(options.segmentation))
    fault(violation.field, violation.description);
  if (!faults.empty()) return absl::InvalidArgumentError(faults);
  return options;
}

}  // namespace segserve::ros
