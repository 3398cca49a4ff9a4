// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/server_info_json.hpp"

#include <algorithm>
#include <string>
#include <string_view>

#include "nlohmann/json.hpp"
#include "proto/wire/codec_message.hpp"
#include "proto/wire/options_message.hpp"
#include "segserve/v1/segmentation_service.pb.h"

namespace segserve::segctl {
namespace {

using Json = nlohmann::ordered_json;

/// Turns "PAYLOAD_KIND_PCD_FILE" into "pcd_file".
std::string short_name(std::string text, std::string_view prefix) {
  if (text.starts_with(prefix)) text.erase(0, prefix.size());
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return text;
}

Json limits_json(const v1::Limits& limits) {
  return {{"max_message_bytes", limits.max_message_bytes()},
          {"max_points", limits.max_points()},
          {"max_decoded_bytes", limits.max_decoded_bytes()},
          {"max_threads", limits.max_threads()},
          {"workers", limits.workers()},
          {"max_queue", limits.max_queue()},
          {"max_queue_bytes", limits.max_queue_bytes()},
          {"max_queue_points", limits.max_queue_points()},
          {"max_voxels", limits.max_voxels()},
          {"memory_bytes", limits.memory_bytes()},
          {"max_frame_seconds", limits.max_frame_seconds()}};
}

/// The codecs of this program that the server can decode.
Json codecs_json(const client::ServerInfo& info) {
  Json list = Json::array();
  for (const wire::CodecInfo& codec : wire::codecs()) {
    if (std::ranges::find(info.payload_kinds(), codec.kind) == info.payload_kinds().end()) continue;
    list.push_back({{"name", codec.name}, {"lossless", codec.is_lossless}, {"description", codec.description}});
  }
  return list;
}

Json option_json(const v1::OptionInfo& option) {
  return {{"name", option.name()},
          {"unit", option.unit()},
          {"minimum", option.minimum()},
          {"maximum", option.maximum()},
          {"default", option.has_default_value() ? Json(option.default_value()) : Json()},
          {"description", option.description()}};
}

std::string default_method(const client::ServerInfo& info) {
  for (const v1::MethodInfo& method : info.methods()) {
    if (method.method() == info.default_options().method()) return method.name();
  }
  return "";
}

/// null where the cloud decides.
Json voxel_resolution_json(const v1::SegmentOptions& options) {
  return options.has_voxel_resolution() ? Json(options.voxel_resolution()) : Json();
}
Json seed_resolution_json(const v1::SegmentOptions& options) {
  return options.has_seed_resolution() ? Json(options.seed_resolution()) : Json();
}

}  // namespace

Json server_info_json(const client::ServerInfo& info) {
  Json json;
  json["version"] = info.version();
  json["payload_kinds"] = Json::array();
  for (const int kind : info.payload_kinds()) {
    const auto text = v1::PayloadKind_Name(static_cast<v1::PayloadKind>(kind));
    json["payload_kinds"].push_back(short_name(text, "PAYLOAD_KIND_"));
  }
  json["compressions"] = Json::array();
  for (const int compression : info.compressions()) {
    const auto text = v1::Compression_Name(static_cast<v1::Compression>(compression));
    json["compressions"].push_back(short_name(text, "COMPRESSION_"));
  }
  json["codecs"] = codecs_json(info);
  json["limits"] = limits_json(info.limits());
  json["default_method"] = default_method(info);
  json["methods"] = Json::array();
  for (const v1::MethodInfo& method : info.methods()) {
    json["methods"].push_back({{"name", method.name()},
                               {"default_threshold", method.defaults().threshold()},
                               {"default_voxel_resolution", voxel_resolution_json(method.defaults())},
                               {"default_seed_resolution", seed_resolution_json(method.defaults())}});
  }
  json["options"] = Json::array();
  for (const v1::OptionInfo& option : info.options()) json["options"].push_back(option_json(option));
  return json;
}

}  // namespace segserve::segctl
