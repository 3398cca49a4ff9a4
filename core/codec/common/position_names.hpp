// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "segserve/codec/length_unit.hpp"

// The names that programs give to coordinates, other than x, y and z.
namespace segserve::codec {

/// The unit that three names or texts give to x, y and z.
struct TextUnit {
  std::optional<LengthUnit> unit = std::nullopt;  ///< nullopt if they say nothing, or if there is a doubt
  std::string doubt = {};  ///< what follows "the coordinates are taken as m, " if a unit is not known, or they differ
};

/// Which of some names are those of the coordinates.
struct PositionNames {
  std::array<std::size_t, 3> fields{};  ///< x, y and z
  TextUnit unit = {};                   ///< that the names tell
};

/// Finds names of the kind of x_mm, pos_x, position.x, x_coord, Points:0 and easting, in any case, also with a unit
/// behind them. x, y and z come first.
std::optional<PositionNames> find_position_names(const std::vector<std::string_view>& names);

/// The unit of length that a text such as mm, [mm], (meters) or US ft names; nullopt for other texts. US survey feet
/// are taken as feet.
std::optional<LengthUnit> unit_in_words(std::string_view text);

/// The text without a pair of brackets around it.
std::string_view without_brackets(std::string_view text);

/// The unit that three texts have in common. Each may be empty, or have brackets around it.
TextUnit unit_of_words(const std::array<std::string_view, 3>& texts);

/// Whether the names are those of latitudes and longitudes, which are degrees and no coordinates.
bool are_degrees(const std::vector<std::string_view>& names);

/// Why degrees are refused, for messages.
inline constexpr std::string_view kDegreesAreRefused =
    "latitudes and longitudes are no coordinates in meters; project them first, for example to UTM";

/// Which names of coordinates are known, for messages.
inline constexpr std::string_view kKnownPositions =
    "x y z, also with a unit as in x_mm, pos_x, x_coord, Points:0, or easting northing elevation";

}  // namespace segserve::codec
