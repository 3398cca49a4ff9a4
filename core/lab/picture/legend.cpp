// SPDX-License-Identifier: Apache-2.0
#include "core/lab/picture/legend.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <string>

#include "fmt/format.h"

namespace segserve::picture {
namespace {

constexpr int kMargin = 12;
constexpr int kRow = 20;
constexpr int kSwatch = 14;
constexpr int kHeadRows = 2;
constexpr std::size_t kLeastEntries = 12;  // a small picture gets higher, so that its legend has room for them

/// The widths of the columns of labels and points, in characters.
struct Columns {
  std::size_t label = 1;
  std::size_t points = 6;
};

Columns columns_of(std::span<const LegendEntry> entries) {
  Columns columns;
  for (const LegendEntry& entry : entries) {
    columns.label = std::max(columns.label, fmt::formatted_size("{}", entry.label));
    columns.points = std::max(columns.points, fmt::formatted_size("{}", entry.points));
  }
  return columns;
}

std::string row_text(const Columns& columns, const std::string& label, const std::string& points,
                     const std::string& share) {
  return fmt::format("{:>{}} {:>{}} {:>5}", label, columns.label, points, columns.points, share);
}

int height_for(std::size_t rows) { return 2 * kMargin + kRow * static_cast<int>(rows); }

/// Where a segment is seen: the sums of its pixels, and later its pixel that is nearest to their mean.
struct Mark {
  double x = 0.0;
  double y = 0.0;
  double pixels = 0.0;
  double nearest = std::numeric_limits<double>::infinity();
  Pixel at = {};
};

std::map<std::uint32_t, Mark> marks_of(const Raster& raster, std::span<const std::uint32_t> labels) {
  std::map<std::uint32_t, Mark> marks;
  const auto each = [&](const auto& visit) {
    for (std::uint32_t y = 0; y < raster.height; ++y) {
      for (std::uint32_t x = 0; x < raster.width; ++x) {
        const std::uint32_t point = raster.point[std::size_t{y} * raster.width + x];
        if (point != Raster::kNoPoint && labels[point] != 0) visit(marks[labels[point]], x, y);
      }
    }
  };
  each([](Mark& mark, std::uint32_t x, std::uint32_t y) {
    mark.x += x;
    mark.y += y;
    mark.pixels += 1.0;
  });
  each([](Mark& mark, std::uint32_t x, std::uint32_t y) {
    const double dx = x - mark.x / mark.pixels;
    const double dy = y - mark.y / mark.pixels;
    if (dx * dx + dy * dy >= mark.nearest) return;
    mark.nearest = dx * dx + dy * dy;
    mark.at = {static_cast<int>(x), static_cast<int>(y)};
  });
  return marks;
}

/// Writes the label onto a segment that is large enough for it.
void draw_mark(const Mark& mark, std::uint32_t label, Canvas& canvas) {
  const std::string text = fmt::format("{}", label);
  const int width = text_width(text) + 4;
  const int height = kTextHeight + 4;
  if (mark.pixels < 3.0 * width * height) return;
  const Pixel corner{mark.at.x - width / 2, mark.at.y - height / 2};
  canvas.fill({corner.x, corner.y, width, height}, kPanelColor);
  canvas.text({corner.x + 3, corner.y + 2}, text, kTextColor);
}

}  // namespace

std::vector<LegendEntry> legend_entries(std::span<const std::uint32_t> labels, const SegmentColors& colors) {
  std::map<std::uint32_t, std::size_t> points;
  for (const std::uint32_t label : labels) {
    if (label != 0) ++points[label];
  }
  std::vector<LegendEntry> entries;
  entries.reserve(points.size());
  for (const auto& [label, count] : points) entries.push_back({label, colors(label), count});
  std::ranges::stable_sort(entries, std::ranges::greater(), &LegendEntry::points);
  return entries;
}

int legend_width(std::span<const LegendEntry> entries) {
  const std::string row = row_text(columns_of(entries), "", "", "");
  const int least = text_width(fmt::format("{} segments", entries.size()));
  return 2 * kMargin + std::max(kSwatch + 8 + text_width(row), least);
}

std::size_t legend_room(std::size_t entries, int height) {
  const int rows = (height - 2 * kMargin) / kRow - kHeadRows;
  if (rows >= static_cast<int>(entries)) return entries;
  return static_cast<std::size_t>(std::max(rows - 1, 0));  // The last row says how many more there are.
}

void draw_legend(std::span<const LegendEntry> entries, const Box& box, Canvas& canvas) {
  const Columns columns = columns_of(entries);
  const auto all = std::accumulate(entries.begin(), entries.end(), std::size_t{0},
                                   [](std::size_t sum, const LegendEntry& entry) { return sum + entry.points; });
  Pixel at{box.left + kMargin, box.top + kMargin};
  const int text_left = at.x + kSwatch + 8;
  const auto next = [&at] { at.y += kRow; };
  canvas.text(at, fmt::format("{} segment{}", entries.size(), entries.size() == 1 ? "" : "s"), kTextColor);
  if (entries.empty()) return;
  next();
  canvas.text({text_left, at.y}, row_text(columns, "#", "points", "%"), kFaintTextColor);
  next();
  const std::size_t shown = legend_room(entries.size(), box.height);
  for (const LegendEntry& entry : entries.first(shown)) {
    canvas.fill({at.x, at.y, kSwatch, kSwatch}, entry.rgb);
    const double share = 100.0 * static_cast<double>(entry.points) / static_cast<double>(all);
    canvas.text({text_left, at.y},
                row_text(columns, fmt::format("{}", entry.label), fmt::format("{}", entry.points),
                         fmt::format("{:.1f}", share)),
                kTextColor);
    next();
  }
  if (shown < entries.size()) canvas.text(at, fmt::format("and {} more", entries.size() - shown), kFaintTextColor);
}

Image with_legend(const Image& picture, const Raster& raster, std::span<const std::uint32_t> labels,
                  const SegmentColors& colors) {
  const std::vector<LegendEntry> entries = legend_entries(labels, colors);
  const std::size_t least = std::min(entries.size(), kLeastEntries) + kHeadRows + 1;
  const int width = legend_width(entries);
  const int height = std::max(static_cast<int>(picture.height), height_for(least));
  Image image =
      blank_image(picture.width + static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height), kPanelColor);
  Canvas canvas(image);
  canvas.paste({0, 0}, picture);
  const auto marks = marks_of(raster, labels);
  for (const LegendEntry& entry : std::span(entries).first(legend_room(entries.size(), height))) {
    if (const auto mark = marks.find(entry.label); mark != marks.end()) draw_mark(mark->second, entry.label, canvas);
  }
  draw_legend(entries, {static_cast<int>(picture.width), 0, width, height}, canvas);
  return image;
}

}  // namespace segserve::picture
