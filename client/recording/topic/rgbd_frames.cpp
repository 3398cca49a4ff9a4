// SPDX-License-Identifier: Apache-2.0
#include "client/recording/topic/rgbd_frames.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <string_view>
#include <utility>

#include "client/recording/images/recorded_color.hpp"
#include "client/recording/images/recorded_depth.hpp"
#include "client/recording/topic/parse_message.hpp"
#include "client/recording/topic/topic_view.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"

namespace segserve::recording {
namespace {

constexpr std::string_view kDistorted =
    "the camera info tells of a distorted lens, which is not corrected: points away from the center of the image are "
    "displaced; a rectified topic (image_rect) has none";

/// The time between two images, nanoseconds. Stamps of damaged messages may be any number.
std::uint64_t gap(const KeptMessage& a, const KeptMessage& b) {
  const auto [early, late] = std::minmax(a.stamp, b.stamp);
  return static_cast<std::uint64_t>(late) - static_cast<std::uint64_t>(early);
}

/// Header and pixels of a depth image.
struct Depth {
  RosHeader header;
  DepthImage image;
};

absl::StatusOr<Depth> read_depth(const KeptMessage& depth, const codec::DecodeLimits& limits, const StopToken& stop) {
  Depth result;
  if (depth.type.kind == MessageKind::kRawImage) {
    ASSIGN_OR_RETURN(RawImage image, parse_raw_image(depth.type.encoding, depth.bytes));
    result.header = image.header;
    ASSIGN_OR_RETURN(result.image, decode_depth(image, limits, stop));
  } else {
    ASSIGN_OR_RETURN(CompressedImage image, parse_compressed_image(depth.type.encoding, depth.bytes));
    result.header = image.header;
    ASSIGN_OR_RETURN(result.image, decode_depth(image, limits, stop));
  }
  return result;
}

/// The image, and how it is damaged.
absl::StatusOr<codec::JpegImage> read_color(const KeptMessage& color, const codec::DecodeLimits& limits,
                                            const StopToken& stop) {
  if (color.type.kind == MessageKind::kRawImage) {
    ASSIGN_OR_RETURN(const RawImage image, parse_raw_image(color.type.encoding, color.bytes));
    ASSIGN_OR_RETURN(auto decoded, decode_color(image, limits));
    return codec::JpegImage{std::move(decoded), ""};
  }
  ASSIGN_OR_RETURN(const CompressedImage image, parse_compressed_image(color.type.encoding, color.bytes));
  return decode_color(image, limits, stop);
}

absl::Status add_color(const std::optional<KeptMessage>& color, const codec::DecodeLimits& limits,
                       const StopToken& stop, codec::LabeledCloud& content) {
  Cloud& cloud = content.cloud;
  if (!color) return absl::NotFoundError("there is no color image within 0.1 s");
  ASSIGN_OR_RETURN(const codec::JpegImage decoded, read_color(*color, limits, stop));
  const codec::ColorImage& image = decoded.image;
  if (!decoded.damage.empty()) {
    content.warnings.push_back({codec::WarningReason::kImageDamaged, "the color image is damaged: " + decoded.damage});
  }
  if (image.size != codec::ImageSize{cloud.width, cloud.height}) {
    return absl::InvalidArgumentError(fmt::format("the color image has {} x {} pixels, but the depth image has {} x {}",
                                                  image.size.width, image.size.height, cloud.width, cloud.height));
  }
  cloud.rgb.resize(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.rgb[i] = pack_rgb(image.rgb[3 * i], image.rgb[3 * i + 1], image.rgb[3 * i + 2]);
  }
  return absl::OkStatus();
}

/// The intrinsics of an image of that size.
absl::StatusOr<codec::Intrinsics> intrinsics_of(const CameraInfo& camera, bool is_rectified,
                                                const codec::ImageSize& size) {
  if (camera.width != 0 && codec::ImageSize{camera.width, camera.height} != size) {
    return absl::InvalidArgumentError(
        fmt::format("the camera info is for {} x {} pixels, but the depth image has {} x {}", camera.width,
                    camera.height, size.width, size.height));
  }
  codec::Intrinsics intrinsics{camera.k[0], camera.k[4], camera.k[2], camera.k[5]};
  if (is_rectified && camera.p[0] != 0) intrinsics = {camera.p[0], camera.p[5], camera.p[2], camera.p[6]};
  const absl::Status checked = codec::check_intrinsics(intrinsics);
  if (!checked.ok()) return with_prefix("camera info", checked);
  return intrinsics;
}

absl::StatusOr<codec::LabeledCloud> make_cloud(const ImagePair& pair, const DepthImage& depth, const CameraInfo& camera,
                                               bool is_rectified, const client::TopicReaderOptions& options,
                                               const StopToken& stop) {
  codec::LabeledCloud content;
  ASSIGN_OR_RETURN(const codec::Intrinsics intrinsics, intrinsics_of(camera, is_rectified, depth.size));
  ASSIGN_OR_RETURN(content.cloud, to_cloud(depth, intrinsics, stop));
  if (options.view) content.cloud.view = *options.view;
  content.view_rule = options.view ? given_view_rule(*options.view) : "CAMERA: images are seen by their camera";
  if (depth.largest > 0) {
    content.warnings.push_back(
        {codec::WarningReason::kPointsNotUsed,
         fmt::format("depth: {} of {} pixels are 65535, which is no distance; they become no points", depth.largest,
                     depth.size.pixels())});
  }
  const bool is_distorted = std::ranges::any_of(camera.distortion, [](double value) { return value != 0; });
  if (is_distorted && !is_rectified) {
    codec::Warning& warning = content.warnings.emplace_back();
    warning.reason = codec::WarningReason::kOther;
    warning.message = kDistorted;
  }
  if (options.color_topic.empty()) return content;
  if (const absl::Status added = add_color(pair.color, options.limits, stop, content); !added.ok()) {
    content.warnings.push_back({codec::WarningReason::kColorNotUsed, message_of(added)});
  }
  return content;
}

}  // namespace

std::size_t ImagePairing::bytes() const {
  std::size_t sum = 0;
  for (const auto* images : {&waiting_, &colors_}) {
    for (const KeptMessage& image : *images) sum += image.bytes.size();
  }
  return sum;
}

void ImagePairing::add_color(KeptMessage color) {
  colors_.push_back(std::move(color));
  while (colors_.size() > kMostWaiting || (colors_.size() > 1 && bytes() > kMostBytes)) colors_.pop_front();
}

std::optional<ImagePair> ImagePairing::take() {
  if (waiting_.empty()) return std::nullopt;
  const KeptMessage& depth = waiting_.front();
  const bool is_settled = !with_color_ || finished_ || waiting_.size() > kMostWaiting || bytes() > kMostBytes ||
                          (!colors_.empty() && colors_.back().stamp >= depth.stamp);
  if (!is_settled) return std::nullopt;
  ImagePair pair{std::move(waiting_.front()), std::nullopt};
  waiting_.pop_front();
  const auto nearest =
      std::ranges::min_element(colors_, {}, [&pair](const KeptMessage& color) { return gap(color, pair.depth); });
  if (nearest != colors_.end() && gap(*nearest, pair.depth) <= kLargestGap) pair.color = *nearest;
  return pair;
}

KeptMessage keep_image(const MessageType& type, const Message& message) {
  KeptMessage kept{type, message, std::string(message.data), static_cast<std::int64_t>(message.log_time)};
  kept.message.data = {};
  if (type.kind == MessageKind::kRawImage) {
    if (const auto image = parse_raw_image(type.encoding, kept.bytes); image.ok()) kept.stamp = image->header.stamp;
  } else if (const auto image = parse_compressed_image(type.encoding, kept.bytes); image.ok()) {
    kept.stamp = image->header.stamp;
  }
  return kept;
}

void read_pair(const ImagePair& pair, const CameraInfo& camera, bool is_rectified,
               const client::TopicReaderOptions& options, const StopToken& stop, client::TopicFrame& frame) {
  const auto depth = read_depth(pair.depth, options.limits, stop);
  if (!depth.ok()) {
    frame.content = depth.status();
    return;
  }
  frame.stamp = client::RecordingTime(std::chrono::nanoseconds(depth->header.stamp));
  frame.frame_id = depth->header.frame_id;
  frame.content = make_cloud(pair, depth->image, camera, is_rectified, options, stop);
}

}  // namespace segserve::recording
