// SPDX-License-Identifier: Apache-2.0
#include <optional>
#include <string>
#include <utility>

#include "core/base/status_macros.hpp"
#include "proto/wire/block_message.hpp"
#include "proto/wire/payload/payload_codecs.hpp"
#include "proto/wire/payload/payload_support.hpp"
#include "segserve/codec/rgbd.hpp"
#include "segserve/codec/rgbd_encode.hpp"

namespace segserve::wire {
namespace {

std::optional<codec::Intrinsics> color_intrinsics(const v1::RgbdImages& message) {
  if (!message.has_color_intrinsics()) return std::nullopt;
  const v1::Intrinsics& camera = message.color_intrinsics();
  return codec::Intrinsics{.fx = camera.fx(), .fy = camera.fy(), .cx = camera.cx(), .cy = camera.cy()};
}

void set_color_intrinsics(const codec::Intrinsics& camera, v1::RgbdImages& message) {
  v1::Intrinsics& intrinsics = *message.mutable_color_intrinsics();
  intrinsics.set_fx(camera.fx);
  intrinsics.set_fy(camera.fy);
  intrinsics.set_cx(camera.cx);
  intrinsics.set_cy(camera.cy);
}

}  // namespace

absl::StatusOr<DecodedCloud> decode_rgbd(const v1::Cloud& message, const std::optional<View>& /*view*/,
                                         const codec::DecodeLimits& limits, const StopToken& stop) {
  const v1::RgbdImages& rgbd = message.rgbd();
  std::string depth_buffer;
  std::string color_buffer;
  ASSIGN_OR_RETURN(const std::string_view depth,
                   block_bytes_up_to(rgbd.depth(), limits.max_bytes, "cloud.rgbd.depth", depth_buffer));
  ASSIGN_OR_RETURN(const std::string_view color,
                   block_bytes_up_to(rgbd.color(), limits.max_bytes, "cloud.rgbd.color", color_buffer));
  const codec::RgbdImages images{.depth = depth,
                                 .color = color,
                                 .depth_scale = rgbd.depth_scale(),
                                 .intrinsics = {.fx = rgbd.fx(), .fy = rgbd.fy(), .cx = rgbd.cx(), .cy = rgbd.cy()},
                                 .color_intrinsics = color_intrinsics(rgbd)};
  ASSIGN_OR_RETURN(auto decoded, with_decode_reason(codec::decode_rgbd(images, limits, stop)));
  RETURN_IF_ERROR(check_shape_agrees(message, decoded.cloud, "the depth image"));
  return DecodedCloud{std::move(decoded.cloud), std::move(decoded.view_rule), std::move(decoded.warnings)};
}

v1::Cloud to_rgbd_message(codec::RgbdFiles images) {
  v1::Cloud message;
  if (const auto format = codec::depth_format(images.depth); format.ok()) {
    message.set_width(format->width);
    message.set_height(format->height);
  }
  *message.mutable_view() = to_message(View::camera());
  message.set_error_bound(images.error_bound);
  v1::RgbdImages& rgbd = *message.mutable_rgbd();
  *rgbd.mutable_depth() = to_raw_block(std::move(images.depth));
  if (!images.color.empty()) *rgbd.mutable_color() = to_raw_block(std::move(images.color));
  rgbd.set_depth_scale(images.depth_scale);
  rgbd.set_fx(images.intrinsics.fx);
  rgbd.set_fy(images.intrinsics.fy);
  rgbd.set_cx(images.intrinsics.cx);
  rgbd.set_cy(images.intrinsics.cy);
  if (images.color_intrinsics) set_color_intrinsics(*images.color_intrinsics, rgbd);
  return message;
}

absl::StatusOr<v1::Cloud> to_rgbd_message(const CloudView& cloud, int jpeg_quality) {
  ASSIGN_OR_RETURN(codec::RgbdFiles images, codec::encode_rgbd(cloud, {.jpeg_quality = jpeg_quality}));
  return to_rgbd_message(std::move(images));
}

}  // namespace segserve::wire
