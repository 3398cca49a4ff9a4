// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "core/lab/picture/picture.hpp"

namespace segserve::picture {

/// The size of the pictures on a contact sheet, in pixels.
inline constexpr std::uint32_t kSheetPictureWidth = 240;
inline constexpr std::uint32_t kSheetPictureHeight = 180;

/// One picture of a contact sheet.
struct SheetEntry {
  std::string name;              ///< of the file; too long ones lose their middle
  std::string note;              ///< a line below the name, such as "31 segments"
  std::optional<Image> picture;  ///< of at most the size above; unset if there is none
};

/// A picture of at most the size that fits a contact sheet.
Image sheet_picture(const CloudView& cloud, std::span<const std::uint32_t> labels);

/// All pictures in rows, each with its name and note. The sheet is about four by three if there are many. `title` is at
/// the top.
Image make_contact_sheet(std::span<const SheetEntry> entries, const std::string& title);

}  // namespace segserve::picture
