// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>
#include <utility>
#include <vector>

#include "client/recording/images/recorded_color.hpp"
#include "client/recording/images/recorded_depth.hpp"
#include "client/recording/topic/parse_message.hpp"
#include "segserve/codec/strided.hpp"

namespace segserve::recording {
namespace {

constexpr codec::DecodeLimits kLimits{.max_points = 100'000, .max_bytes = 4'000'000};

void read_cloud(MessageEncoding encoding, std::string_view bytes) {
  const auto cloud = parse_cloud(encoding, bytes);
  if (!cloud.ok() || !codec::check_layout(cloud->layout, kLimits).ok()) return;
  if (cloud->data.size() != cloud->layout.bytes()) return;
  const std::size_t points = std::size_t{cloud->layout.width} * cloud->layout.height;
  const auto labeled = add_labels(cloud->layout, cloud->data, std::vector<std::uint32_t>(points));
  if (labeled.ok() && labeled->data.size() != labeled->layout.bytes()) std::abort();
}

absl::StatusOr<codec::ColorImage> color_of(const RawImage& image) { return decode_color(image, kLimits); }

absl::StatusOr<codec::ColorImage> color_of(const CompressedImage& image) {
  auto color = decode_color(image, kLimits, {});
  if (!color.ok()) return color.status();
  return std::move(color->image);
}

template <typename Image>
void read_image(const absl::StatusOr<Image>& image) {
  if (!image.ok()) return;
  const auto depth = decode_depth(*image, kLimits, {});
  if (depth.ok() && depth->meters.size() != depth->size.pixels()) std::abort();
  const auto color = color_of(*image);
  if (color.ok() && color->rgb.size() != 3 * color->size.pixels()) std::abort();
}

}  // namespace
}  // namespace segserve::recording

// Messages of recordings. The first byte chooses the kind, the second one the encoding.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace segserve::recording;
  if (size < 2) return 0;
  const auto encoding = static_cast<MessageEncoding>(data[1] % 3);
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 2, size - 2);
  switch (static_cast<MessageKind>(data[0] % 4)) {
    case MessageKind::kPointCloud2:
      read_cloud(encoding, bytes);
      break;
    case MessageKind::kRawImage:
      read_image(parse_raw_image(encoding, bytes));
      break;
    case MessageKind::kCompressedImage:
      read_image(parse_compressed_image(encoding, bytes));
      break;
    case MessageKind::kCameraInfo:
      static_cast<void>(parse_camera_info(encoding, bytes));
      break;
  }
  return 0;
}
