// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>

#include "core/lab/picture/canvas.hpp"
#include "core/lab/picture/legend.hpp"
#include "core/lab/picture/picture.hpp"
#include "core/lab/picture/raster.hpp"
#include "core/lab/picture/segment_colors.hpp"

namespace segserve::picture {
namespace {

using Color = std::array<float, 3>;  // 0 to 255

Color unpack(std::uint32_t rgb) {
  return {static_cast<float>(red(rgb)), static_cast<float>(green(rgb)), static_cast<float>(blue(rgb))};
}

Color mix(const Color& a, const Color& b, float share_of_b) {
  Color out{};
  for (std::size_t i = 0; i < 3; ++i) out[i] = a[i] + (b[i] - a[i]) * share_of_b;
  return out;
}

Color scaled(Color color, float factor) {
  for (float& channel : color) channel *= factor;
  return color;
}

void put(const Color& color, std::size_t pixel, Image& image) {
  for (std::size_t i = 0; i < 3; ++i) {
    image.rgb[3 * pixel + i] = static_cast<std::uint8_t>(std::clamp(color[i] + 0.5F, 0.0F, 255.0F));
  }
}

/// Luma, 0 to 1.
float luma(const Color& c) { return (0.299F * c[0] + 0.587F * c[1] + 0.114F * c[2]) / 255.0F; }

/// The color of a point without color: light gray nearby, dark gray far away.
class DepthShade {
 public:
  explicit DepthShade(const Raster& raster) {
    std::vector<float> depths;
    for (std::size_t i = 0; i < raster.depth.size(); ++i) {
      if (raster.point[i] != Raster::kNoPoint) depths.push_back(raster.depth[i]);
    }
    if (depths.empty()) return;
    const auto quantile = [&](std::size_t percent) {
      const std::size_t rank = (depths.size() - 1) * percent / 100;
      std::nth_element(depths.begin(), depths.begin() + static_cast<std::ptrdiff_t>(rank), depths.end());
      return depths[rank];
    };
    nearest_ = quantile(2);
    farthest_ = quantile(98);
  }

  Color operator()(float depth) const {
    const float range = std::max(farthest_ - nearest_, 1e-6F);
    const float far = std::clamp((depth - nearest_) / range, 0.0F, 1.0F);
    return scaled(unpack(0xD8D8DC), 1.0F - 0.65F * far);
  }

 private:
  float nearest_ = 0.0F;
  float farthest_ = 0.0F;
};

/// The color of the segment with the brightness of the point, so that texture stays visible.
Color paint(const Color& own, std::uint32_t rgb, float blend) {
  const Color segment = scaled(unpack(rgb), 0.45F + 0.75F * luma(own));
  return mix(own, segment, blend);
}

Image paint_points(const CloudView& cloud, std::span<const std::uint32_t> labels, const RenderOptions& options,
                   const Raster& raster, const SegmentColors& colors) {
  Image image{raster.width, raster.height, std::vector<std::uint8_t>(3 * raster.point.size())};
  const DepthShade shade(raster);
  const float blend = std::clamp(options.blend, 0.0F, 1.0F);
  for (std::size_t pixel = 0; pixel < raster.point.size(); ++pixel) {
    const std::uint32_t point = raster.point[pixel];
    if (point == Raster::kNoPoint) {
      put(unpack(options.background), pixel, image);
      continue;
    }
    const Color own = cloud.has_color() ? unpack(cloud.rgb[point]) : shade(raster.depth[pixel]);
    put(labels.empty() ? own : paint(own, colors(labels[point]), blend), pixel, image);
  }
  return image;
}

void darken(std::size_t pixel, float factor, Image& image) {
  for (std::size_t i = 0; i < 3; ++i) {
    image.rgb[3 * pixel + i] = static_cast<std::uint8_t>(factor * static_cast<float>(image.rgb[3 * pixel + i]));
  }
}

/// Darkens the pixels whose right or lower neighbor belongs to another segment. The lines are one pixel wide.
void draw_borders(std::span<const std::uint32_t> labels, const Raster& raster, Image& image) {
  const auto label = [&](std::size_t pixel) {
    return raster.point[pixel] == Raster::kNoPoint ? 0U : labels[raster.point[pixel]];
  };
  const auto differ = [&](std::size_t a, std::size_t b) {
    return label(a) != 0 && label(b) != 0 && label(a) != label(b);
  };
  for (std::size_t y = 0; y < raster.height; ++y) {
    for (std::size_t x = 0; x < raster.width; ++x) {
      const std::size_t pixel = y * raster.width + x;
      const bool right = x + 1 < raster.width && differ(pixel, pixel + 1);
      const bool lower = y + 1 < raster.height && differ(pixel, pixel + raster.width);
      if (right || lower) darken(pixel, 0.25F, image);
    }
  }
}

/// Eye-dome lighting (C. Boucheny, 2009): a pixel gets darker the more its neighbors are in front of it. This shows
/// edges and folds without normals.
void light_edges(const Raster& raster, Image& image) {
  const auto log_depth = [&](std::size_t x, std::size_t y) {
    const std::size_t pixel = y * raster.width + x;
    return raster.point[pixel] == Raster::kNoPoint ? 0.0F : std::log2(raster.depth[pixel]);
  };
  constexpr float kNoise = 0.008F;  // depth steps on smooth surfaces, as differences of log2
  constexpr std::array<std::array<int, 2>, 8> kAround{
      {{-2, 0}, {2, 0}, {0, -2}, {0, 2}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}}};
  for (std::size_t y = 2; y + 2 < raster.height; ++y) {
    for (std::size_t x = 2; x + 2 < raster.width; ++x) {
      const std::size_t pixel = y * raster.width + x;
      if (raster.point[pixel] == Raster::kNoPoint) continue;
      float in_front = 0.0F;
      for (const auto& [dx, dy] : kAround) {
        const std::size_t nx = x + static_cast<std::size_t>(dx);
        const std::size_t ny = y + static_cast<std::size_t>(dy);
        if (raster.point[ny * raster.width + nx] == Raster::kNoPoint) continue;
        in_front += std::max(0.0F, log_depth(x, y) - log_depth(nx, ny) - kNoise);
      }
      constexpr float kStrength = 6.0F;
      darken(pixel, std::max(0.25F, std::exp(-kStrength * in_front)), image);
    }
  }
}

bool is_seen_as_image(const CloudView& cloud, const RenderOptions& options) {
  return cloud.height > 1 && !options.view_from;
}

Raster rasterize(const CloudView& cloud, const RenderOptions& options) {
  if (is_seen_as_image(cloud, options)) return rasterize_organized(cloud);
  return rasterize_projected(cloud, options.width, options.height, options.view_from);
}

}  // namespace

Image render(const CloudView& cloud, std::span<const std::uint32_t> labels, const RenderOptions& options) {
  const bool is_image = is_seen_as_image(cloud, options);
  const Raster raster = rasterize(cloud, options);
  SegmentColors own_colors;
  SegmentColors& colors = options.colors == nullptr ? own_colors : *options.colors;
  if (!labels.empty()) colors.update(labels_by_size(raster, labels), label_neighbors(raster, labels));
  Image image = paint_points(cloud, labels, options, raster, colors);
  const bool is_empty =
      std::ranges::all_of(raster.point, [](std::uint32_t point) { return point == Raster::kNoPoint; });
  if (is_empty) Canvas(image).text_in_middle(kNoPointsText, kFaintTextColor);
  if (!is_image) light_edges(raster, image);
  if (is_image && options.borders && !labels.empty()) draw_borders(labels, raster, image);
  return options.legend && !labels.empty() ? with_legend(image, raster, labels, colors) : image;
}

SegmentColors colors_in_picture(const CloudView& cloud, std::span<const std::uint32_t> labels,
                                const RenderOptions& options) {
  const Raster raster = rasterize(cloud, options);
  SegmentColors colors = options.colors == nullptr ? SegmentColors() : *options.colors;
  colors.update(labels_by_size(raster, labels), label_neighbors(raster, labels));
  return colors;
}

}  // namespace segserve::picture
