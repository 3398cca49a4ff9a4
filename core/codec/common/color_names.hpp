// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "core/codec/common/field_roles.hpp"

namespace segserve::codec {

/// The names of the three channels of a color, in small letters.
struct ColorNames {
  std::array<std::string, 3> names;
  ChannelKind kind = ChannelKind::kIntensity;
};

/// All names that are known; the usual ones come first.
const std::vector<ColorNames>& color_names();

/// The indices of the fields whose names tell of a color: by a word such as "red" or "rgb8", or by a word r, g or b, if
/// two of these letters occur. One alone may be a range.
std::vector<std::size_t> fields_like_colors(const std::vector<Field>& fields);

}  // namespace segserve::codec
