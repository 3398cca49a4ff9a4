// SPDX-License-Identifier: Apache-2.0
#include "core/lab/picture/contact_sheet.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/lab/picture/canvas.hpp"
#include "core/lab/picture/legend.hpp"

namespace segserve::picture {
namespace {

constexpr int kGap = 16;
constexpr int kLine = 20;
constexpr int kPictureWidth = static_cast<int>(kSheetPictureWidth);
constexpr int kPictureHeight = static_cast<int>(kSheetPictureHeight);
constexpr int kCellWidth = kPictureWidth + kGap;
constexpr int kCellHeight = kPictureHeight + 6 + 2 * kLine + kGap;
constexpr int kTitleHeight = kGap + kLine + 4;
constexpr std::uint32_t kEmptyColor = 0x27272B;

/// The columns that make the sheet about four by three.
std::size_t columns_for(std::size_t entries) {
  const double ideal = std::sqrt(4.0 / 3.0 * kCellHeight / kCellWidth * static_cast<double>(entries));
  const auto least = std::min<std::size_t>(entries, 2);
  return std::clamp<std::size_t>(static_cast<std::size_t>(std::lround(ideal)), least,
                                 std::max<std::size_t>(entries, 1));
}

bool has_finite_point(const CloudView& cloud) {
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (std::isfinite(cloud.x[i]) && std::isfinite(cloud.y[i]) && std::isfinite(cloud.z[i])) return true;
  }
  return false;
}

Image empty_picture() {
  Image image = blank_image(kSheetPictureWidth, kSheetPictureHeight, kEmptyColor);
  Canvas(image).text_in_middle(kNoPointsText, kFaintTextColor);
  return image;
}

void draw_entry(const SheetEntry& entry, Pixel at, Canvas& canvas) {
  canvas.fill({at.x, at.y, kPictureWidth, kPictureHeight}, kEmptyColor);
  if (entry.picture) {
    canvas.paste({at.x + (kPictureWidth - static_cast<int>(entry.picture->width)) / 2,
                  at.y + (kPictureHeight - static_cast<int>(entry.picture->height)) / 2},
                 *entry.picture);
  }
  at.y += kPictureHeight + 8;
  canvas.text(at, shortened(entry.name, kPictureWidth), kTextColor);
  at.y += kLine;
  canvas.text(at, shortened(entry.note, kPictureWidth), kFaintTextColor);
}

}  // namespace

Image sheet_picture(const CloudView& cloud, std::span<const std::uint32_t> labels) {
  if (!has_finite_point(cloud)) return empty_picture();
  // An organized cloud has the size of its image, and may be tall.
  RenderOptions options{.width = 2 * kSheetPictureWidth, .height = 2 * kSheetPictureHeight};
  Image image = render(cloud, labels, options);
  const double tall = static_cast<double>(image.height) / kSheetPictureHeight;
  const auto width = static_cast<std::uint32_t>(image.width / std::max(tall, 1.0));
  return shrink(image, std::clamp(width, 1U, kSheetPictureWidth));
}

Image make_contact_sheet(std::span<const SheetEntry> entries, const std::string& title) {
  const std::size_t columns = std::max<std::size_t>(columns_for(entries.size()), 1);
  const std::size_t rows = (entries.size() + columns - 1) / columns;
  const int width = std::max(kGap + kCellWidth * static_cast<int>(columns), 2 * kGap + text_width(title));
  const int height = kTitleHeight + kCellHeight * static_cast<int>(rows) + kGap / 2;
  Image sheet = blank_image(static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height), kPanelColor);
  Canvas canvas(sheet);
  canvas.text({kGap, kGap}, title, kTextColor);
  for (std::size_t i = 0; i < entries.size(); ++i) {
    draw_entry(
        entries[i],
        {kGap + kCellWidth * static_cast<int>(i % columns), kTitleHeight + kCellHeight * static_cast<int>(i / columns)},
        canvas);
  }
  return sheet;
}

}  // namespace segserve::picture
