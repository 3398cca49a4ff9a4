// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/codec/common/scalar_type.hpp"
#include "segserve/codec/length_unit.hpp"
#include "segserve/codec/warning.hpp"

// The fields of a file: which of them matter, judged by their names and types.
namespace segserve::codec {

/// A field of every point.
struct Field {
  std::string_view name;
  ScalarType type = ScalarType::kFloat32;
  std::size_t count = 1;  ///< numbers per point; 0 if it is not the same for all points

  bool is_single() const { return count == 1; }
};

/// How the three channels of a color are to be read.
enum class ChannelKind : std::uint8_t {
  kSixteenBits,        ///< 0 to 65535
  kIntensity,          ///< 0 to 1, to 255 or to 65535, which the values tell
  kSphericalHarmonic,  ///< the constant term of a Gaussian splat: (color - 1/2) / Y, with Y = sqrt(1 / (4 pi))
};

/// The fields of a file that a cloud is made from, as indices.
struct FieldRoles {
  std::array<std::size_t, 3> position{};               ///< x, y, z
  std::optional<LengthUnit> unit;                      ///< of the position, if its names tell it
  std::optional<std::size_t> packed;                   ///< color as 0xAARRGGBB
  std::optional<std::array<std::size_t, 3>> channels;  ///< color as red, green and blue
  std::optional<std::size_t> color_vector;             ///< color as one field of red, green, blue and maybe alpha
  bool color_vector_is_reversed = false;               ///< blue stands first in color_vector
  ChannelKind channel_kind = ChannelKind::kIntensity;
  std::optional<std::size_t> label;

  bool has_color() const { return packed || channels || color_vector; }
  bool is_position(std::size_t field) const {
    return field == position[0] || field == position[1] || field == position[2];
  }
  /// The fields that make the color.
  std::vector<std::size_t> color_fields() const;
  void drop_color();
  /// All fields that have a role, each once.
  std::vector<std::size_t> fields() const;
};

/// Finds what the fields are by the names that programs give them, in any case; a name in the usual case comes first.
///  - position: x, y, z, or the names that find_position_names knows
///  - color: rgb or rgba, packed in a number of 4 or 8 bytes; or else r g b, red green blue, these with a word before
///  or
///    behind them such as diffuse_red, color_r or R8, f_dc_0 f_dc_1 f_dc_2, or the words of some other languages; or
///    else one field of 3 or 4 numbers: rgb, rgba, bgr, bgra, color or colors
///  - label: label, scalar_Label
/// INVALID_ARGUMENT if there is no position, if a coordinate is more than one number, if a name that is used occurs
/// twice, or if the fields have more than kMostPointNumbers together. Warns of fields that look like color, or like a
/// label, and are not used, and of 4 numbers whose name does not tell that red comes first and alpha last.
absl::StatusOr<FieldRoles> find_field_roles(const std::vector<Field>& fields, std::vector<Warning>& warnings);

/// The text with small letters for the capitals of ASCII.
std::string lower_case(std::string_view text);

/// Whether a field of this name, in any case, can have a role.
bool has_meaning(std::string_view name);

/// The index at which `name` occurs, or nullopt if it does not occur. INVALID_ARGUMENT if it occurs twice.
absl::StatusOr<std::optional<std::size_t>> find_unique(const std::vector<std::string_view>& names,
                                                       std::string_view name);
/// The indices at which the three `wanted` names occur, or nullopt unless all of them do. INVALID_ARGUMENT if one of
/// them occurs twice.
absl::StatusOr<std::optional<std::array<std::size_t, 3>>> find_triple(const std::vector<std::string_view>& names,
                                                                      const std::array<std::string_view, 3>& wanted);

}  // namespace segserve::codec
