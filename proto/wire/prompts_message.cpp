// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/prompts_message.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "fmt/format.h"
#include "proto/wire/segment_message.hpp"
#include "proto/wire/status_message.hpp"

namespace segserve::wire {
namespace {

using PromptMessages = google::protobuf::RepeatedPtrField<v1::Prompt>;
using PointMessages = google::protobuf::RepeatedPtrField<v1::PromptedPoint>;

v1::Prompt to_message(const Prompt& prompt) {
  v1::Prompt message;
  if (const auto* pixel = std::get_if<Pixel>(&prompt)) {
    message.mutable_pixel()->set_column(pixel->column);
    message.mutable_pixel()->set_row(pixel->row);
    return message;
  }
  const auto& position = std::get<Eigen::Vector3d>(prompt);
  message.mutable_position()->set_x(position.x());
  message.mutable_position()->set_y(position.y());
  message.mutable_position()->set_z(position.z());
  return message;
}

std::vector<Prompt> read_prompts(const PromptMessages& messages, std::string_view field,
                                 std::vector<FieldViolation>& faults) {
  std::vector<Prompt> prompts;
  for (int k = 0; k < messages.size(); ++k) {
    const v1::Prompt& message = messages[k];
    if (message.has_pixel()) {
      prompts.emplace_back(Pixel{message.pixel().column(), message.pixel().row()});
    } else {
      const v1::Vector3& position = message.position();
      prompts.emplace_back(Eigen::Vector3d(position.x(), position.y(), position.z()));
      if (!message.has_position()) {
        faults.push_back({fmt::format("prompts.{}[{}]", field, k), "has neither a position nor a pixel"});
      }
    }
  }
  return prompts;
}

void add_violations(const Prompts& prompts, std::vector<FieldViolation>& faults) {
  for (FieldViolation& fault : violations(prompts)) {
    faults.push_back({"prompts." + fault.field, std::move(fault.description)});
  }
}

v1::PromptedPoint to_message(const PromptedPoint& point) {
  v1::PromptedPoint message;
  message.set_point(point.point);
  message.set_supervoxel(point.supervoxel);
  message.set_distance(point.distance);
  return message;
}

absl::Status broken(std::string_view field) {
  return malformed(fmt::format("selection.{}: is out of its range", field));
}

absl::StatusOr<std::vector<PromptedPoint>> read_points(const PointMessages& messages, std::uint64_t points,
                                                       std::uint32_t supervoxels, std::string_view field) {
  std::vector<PromptedPoint> read;
  for (const v1::PromptedPoint& message : messages) {
    const bool is_good = message.point() < points && message.supervoxel() >= 1 && message.supervoxel() <= supervoxels &&
                         std::isfinite(message.distance()) && message.distance() >= 0;
    if (!is_good) return broken(field);
    read.push_back({static_cast<std::size_t>(message.point()), message.supervoxel(), message.distance()});
  }
  return read;
}

absl::StatusOr<Selection> read_selection(const v1::Selection& message, std::uint32_t supervoxels) {
  const std::uint64_t nodes = supervoxels == 0 ? 0 : std::uint64_t{2} * supervoxels - 1;
  const auto is_node = [nodes](std::uint32_t node) { return node < nodes; };
  if (message.smallest().empty() || !std::ranges::all_of(message.smallest(), is_node)) return broken("smallest");
  const int groups = message.smallest_size(), steps = message.step_nodes_size();
  if (message.step_groups_size() != steps) return broken("step_groups");
  if (!std::ranges::all_of(message.step_nodes(), is_node)) return broken("step_nodes");
  Selection selection;
  selection.smallest.assign(message.smallest().begin(), message.smallest().end());
  for (int k = 0; k < steps; ++k) {
    if (message.step_groups(k) >= static_cast<std::uint32_t>(groups)) return broken("step_groups");
    selection.steps.push_back({message.step_groups(k), message.step_nodes(k)});
  }
  return selection;
}

}  // namespace

v1::Prompts to_message(const Prompts& prompts) {
  v1::Prompts message;
  for (const Prompt& prompt : prompts.include) *message.add_include() = to_message(prompt);
  for (const Prompt& prompt : prompts.exclude) *message.add_exclude() = to_message(prompt);
  message.set_larger(prompts.larger);
  return message;
}

Prompts from_message(const v1::Prompts& message, std::vector<FieldViolation>& faults) {
  Prompts prompts;
  prompts.include = read_prompts(message.include(), "include", faults);
  prompts.exclude = read_prompts(message.exclude(), "exclude", faults);
  prompts.larger = message.larger();
  add_violations(prompts, faults);
  return prompts;
}

absl::Status check(const Prompts& prompts) {
  std::vector<FieldViolation> faults;
  add_violations(prompts, faults);
  return invalid_fields(faults);
}

absl::StatusOr<std::optional<PromptedSelection>> select_by_prompts(
    const CloudView& cloud, const codec::Placement& placement, const Segmentation& segmentation, const Options& options,
    const Outputs& outputs, const std::optional<Prompts>& prompts, const StopToken& stop) {
  if (!prompts) return std::nullopt;
  auto selected =
      segserve::select_by_prompts(cloud, segmentation, options.regions, codec::to_cloud(placement, *prompts), stop);
  if (absl::IsInvalidArgument(selected.status())) {
    return invalid_fields({{"prompts", message_of(selected.status())}});
  }
  RETURN_IF_ERROR(selected.status());
  if (outputs.segments) RETURN_IF_ERROR(describe(cloud, options.threads, stop, *selected));
  return *std::move(selected);
}

v1::Selection to_message(const PromptedSelection& selected) {
  v1::Selection message;
  for (const PromptedPoint& point : selected.include) *message.add_include() = to_message(point);
  for (const PromptedPoint& point : selected.exclude) *message.add_exclude() = to_message(point);
  for (const std::uint32_t node : selected.selection.smallest) message.add_smallest(node);
  for (const Selection::Step& step : selected.selection.steps) {
    message.add_step_groups(step.group);
    message.add_step_nodes(step.node);
  }
  message.set_candidate(static_cast<std::uint32_t>(selected.candidate));
  *message.mutable_thresholds() = to_message(selected.thresholds);
  if (selected.statistics) *message.mutable_segment() = to_message(*selected.statistics);
  return message;
}

absl::StatusOr<PromptedSelection> from_message(const v1::Selection& message, std::uint64_t points,
                                               std::uint32_t supervoxels) {
  PromptedSelection selected;
  ASSIGN_OR_RETURN(selected.include, read_points(message.include(), points, supervoxels, "include"));
  ASSIGN_OR_RETURN(selected.exclude, read_points(message.exclude(), points, supervoxels, "exclude"));
  ASSIGN_OR_RETURN(selected.selection, read_selection(message, supervoxels));
  selected.candidate = message.candidate();
  if (selected.candidate >= selected.selection.candidates()) return broken("candidate");
  const auto thresholds = from_message(message.thresholds());
  if (!thresholds) return broken("thresholds");
  selected.thresholds = *thresholds;
  if (message.has_segment()) {
    ASSIGN_OR_RETURN(selected.statistics, from_message(message.segment(), "selection.segment"));
  }
  return selected;
}

}  // namespace segserve::wire
