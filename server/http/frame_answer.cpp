// SPDX-License-Identifier: Apache-2.0
#include "server/http/frame_answer.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>
#include <iterator>
#include <span>
#include <utility>
#include <vector>

#include "core/base/status_macros.hpp"
#include "core/lab/view_page/view_page.hpp"
#include "fmt/format.h"
#include "nlohmann/json.hpp"
#include "proto/text/result_json.hpp"
#include "proto/wire/status_message.hpp"

namespace segserve::server {
namespace {

using Json = nlohmann::ordered_json;

/// Drawing cannot be interrupted, and browsers get slow.
constexpr std::size_t kMostDrawnPoints = 2'000'000;

constexpr std::array kForms{AnswerForm::kJson, AnswerForm::kLabels, AnswerForm::kView};

std::string text_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

/// Adds `,"NAME":[..]` before the last brace of an object. A tree of JSON would take many times the memory.
template <typename Values>
void add_array(std::string_view name, const Values& values, std::string& object) {
  object.pop_back();
  fmt::format_to(std::back_inserter(object), R"({}"{}":[)", object.size() > 1 ? "," : "", name);
  bool is_first = true;
  for (const auto value : values) {
    if (!is_first) object += ',';
    is_first = false;
    fmt::format_to(std::back_inserter(object), "{}", value);
  }
  object += "]}";
}

std::string tree_json(const MergeTree& tree) {
  std::string object = fmt::format(R"({{"merged_rows":{}}})", std::ranges::count(tree.kind, MergeKind::kMerged));
  add_array("leaf_points", tree.leaf_points, object);
  add_array("left", tree.left, object);
  add_array("right", tree.right, object);
  add_array("weight", tree.weight, object);
  return object;
}

std::string json_of(const AnswerContent& content, const wire::Result& result) {
  const Segmentation& segmentation = result.segmentation;
  std::string body = text_of(text::to_json(result, {.server = "",
                                                    .timings = text::stage_timings(result),
                                                    .with_segments = content.outputs.segments,
                                                    .prompts = content.prompts}));
  if (content.outputs.labels) {
    add_array("labels", segmentation.labels, body);
    if (result.selection) add_array("selected", result.selection->labels, body);
  }
  if (content.outputs.supervoxels) add_array("supervoxel_of_point", segmentation.supervoxels, body);
  if (content.outputs.tree) {
    body.pop_back();
    body += ",\"tree\":" + tree_json(segmentation.tree) + "}";
  }
  return body;
}

HttpAnswer labels_answer(const wire::Result& result, const CloudView& cloud) {
  static_assert(std::endian::native == std::endian::little);
  const std::vector<std::uint32_t>& labels = result.selection ? result.selection->labels : result.segmentation.labels;
  HttpAnswer answer;
  answer.headers = {{"Segserve-Array", "uint32, little-endian"},
                    {"Segserve-Points", fmt::format("{}", labels.size())},
                    {"Segserve-Width", fmt::format("{}", cloud.width)},
                    {"Segserve-Height", fmt::format("{}", cloud.height)},
                    {"Segserve-Segments", fmt::format("{}", result.segmentation.segments)}};
  answer.body.resize(labels.size() * sizeof(std::uint32_t));
  if (!labels.empty()) std::memcpy(answer.body.data(), labels.data(), answer.body.size());
  return answer;
}

absl::StatusOr<std::string> view_of(const AnswerContent& content, const wire::Result& result, const CloudView& cloud) {
  if (cloud.size() > kMostDrawnPoints) {
    return wire::limit_exceeded("the cloud to draw has", cloud.size(), "points", "max_drawn_points", kMostDrawnPoints);
  }
  const std::array clouds{view_page::PageCloud{.points = cloud, .truth = {}, .placement = result.placement}};
  const std::array results{view_page::PageResult{.name = content.name,
                                                 .method = std::string(name(result.method)),
                                                 .cloud = 0,
                                                 .segmentation = &result.segmentation,
                                                 .regions = result.regions}};
  ASSIGN_OR_RETURN(const view_page::PageData data, view_page::page_data(content.name, clouds, results));
  Json texts = Json::object();
  for (const auto& [id, text] : data.arrays) texts[id] = text;
  const Json summary = text::to_json(result, {.timings = text::stage_timings(result)});
  return text_of({{"page", data.json}, {"arrays", texts}, {"summary", summary}});
}

}  // namespace

std::string_view content_type(AnswerForm form) {
  switch (form) {
    case AnswerForm::kLabels:
      return "application/octet-stream";
    case AnswerForm::kView:
      return "application/vnd.segserve.view+json";
    default:
      return "application/json";
  }
}

std::optional<AnswerForm> accepted_form(std::string_view accept) {
  if (accept.empty()) return AnswerForm::kJson;
  while (!accept.empty()) {
    std::string_view range = accept.substr(0, accept.find(','));
    accept.remove_prefix(std::min(accept.size(), range.size() + 1));
    range = range.substr(0, range.find(';'));
    while (range.starts_with(' ')) range.remove_prefix(1);
    while (range.ends_with(' ')) range.remove_suffix(1);
    for (const AnswerForm form : kForms) {
      if (range == content_type(form)) return form;
    }
    if (range == "*/*" || range == "application/*") return AnswerForm::kJson;
  }
  return std::nullopt;
}

std::uint64_t bytes_per_point(AnswerForm form) {
  switch (form) {
    case AnswerForm::kLabels:
      return 4;
    case AnswerForm::kView:
      return 96;  // shown points, an array with its planes and gzip, and the text twice
    default:
      return 24;  // the text of two arrays, which may double while it grows
  }
}

absl::StatusOr<HttpAnswer> answer_of(AnswerForm form, const AnswerContent& content, wire::Result& result,
                                     const CloudView& cloud) {
  HttpAnswer answer;
  if (form == AnswerForm::kLabels) {
    answer = labels_answer(result, cloud);
  } else if (form == AnswerForm::kView) {
    ASSIGN_OR_RETURN(answer.body, view_of(content, result, cloud));
  } else {
    answer.body = json_of(content, result);
  }
  answer.headers.emplace_back("Content-Type", content_type(form));
  return answer;
}

}  // namespace segserve::server
