// SPDX-License-Identifier: Apache-2.0
#include "core/codec/common/position_names.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "core/codec/common/field_roles.hpp"

namespace segserve::codec {
namespace {

using Triple = std::array<std::string_view, 3>;

constexpr std::array<Triple, 17> kWhole{{
    {"x", "y", "z"},
    {"points:0", "points:1", "points:2"},
    {"points_m_xyz:0", "points_m_xyz:1", "points_m_xyz:2"},
    {"points_0", "points_1", "points_2"},
    {"xyz_0", "xyz_1", "xyz_2"},
    {"xyz[0]", "xyz[1]", "xyz[2]"},
    {"xyz:0", "xyz:1", "xyz:2"},
    {"easting", "northing", "elevation"},
    {"easting", "northing", "height"},
    {"easting", "northing", "altitude"},
    {"easting", "northing", "z"},
    {"east", "north", "elev"},
    {"east", "north", "up"},
    {"e", "n", "u"},
    {"rechtswert", "hochwert", "höhe"},
    {"e", "n", "z"},
    {"e", "n", "h"},
}};

/// Each pair is the text before and behind the letter x, y or z of a name.
constexpr std::array<std::pair<std::string_view, std::string_view>, 28> kAround{{
    {"pos_", ""},    {"pos.", ""},   {"position_", ""},   {"position.", ""},   {"point_", ""},   {"point.", ""},
    {"points_", ""}, {"coord_", ""}, {"coord.", ""},      {"coordinate_", ""}, {"field.", ""},   {"world_", ""},
    {"map_", ""},    {"utm_", ""},   {"local_", ""},      {"global_", ""},     {"lidar_", ""},   {"laser_", ""},
    {"camera_", ""}, {"cam_", ""},   {"sensor_", ""},     {"pos", ""},         {"position", ""}, {"p", ""},
    {"", "_coord"},  {"", " coord"}, {"", "_coordinate"}, {"", " coordinate"},
}};

struct UnitName {
  std::string_view name;
  LengthUnit unit;
};
constexpr std::array<UnitName, 20> kUnits{{
    {"m", LengthUnit::kMeter},
    {"meter", LengthUnit::kMeter},
    {"meters", LengthUnit::kMeter},
    {"metre", LengthUnit::kMeter},
    {"metres", LengthUnit::kMeter},
    {"cm", LengthUnit::kCentimeter},
    {"centimeters", LengthUnit::kCentimeter},
    {"centimetres", LengthUnit::kCentimeter},
    {"mm", LengthUnit::kMillimeter},
    {"millimeter", LengthUnit::kMillimeter},
    {"millimeters", LengthUnit::kMillimeter},
    {"millimetre", LengthUnit::kMillimeter},
    {"millimetres", LengthUnit::kMillimeter},
    {"in", LengthUnit::kInch},
    {"inch", LengthUnit::kInch},
    {"inches", LengthUnit::kInch},
    {"ft", LengthUnit::kFoot},
    {"foot", LengthUnit::kFoot},
    {"feet", LengthUnit::kFoot},
    {"international foot", LengthUnit::kFoot},
}};

/// A name and its unit are joined by one of these. Behind an underscore only short names of units count, because words
/// such as x_in and x_foot may be names of their own.
constexpr std::array<std::string_view, 3> kBeforeUnit{"_", "/", " in "};

/// A name in small letters, and the unit behind it, which is not part of it.
struct Name {
  std::string text;
  std::optional<LengthUnit> unit;
};

Name without_unit(std::string_view name) {
  constexpr std::array<std::string_view, 4> kShort{"m", "cm", "mm", "ft"};
  const std::string lower = lower_case(name);
  for (const std::string_view between : kBeforeUnit) {
    const std::size_t end = lower.rfind(between);
    if (end == std::string::npos || end == 0) continue;
    const std::string_view behind = std::string_view(lower).substr(end + between.size());
    if (between == "_" && std::ranges::find(kShort, behind) == kShort.end()) continue;
    if (const auto unit = unit_in_words(behind)) return {lower.substr(0, end), unit};
  }
  return {lower, std::nullopt};
}

/// Where three names are that `is_wanted(name, axis)` accepts, with the same unit behind all of them.
template <typename IsWanted>
std::optional<PositionNames> find(const std::vector<Name>& names, IsWanted is_wanted) {
  PositionNames found;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto at = std::ranges::find_if(names, [&](const Name& name) { return is_wanted(name.text, axis); });
    if (at == names.end()) return std::nullopt;
    found.fields[axis] = static_cast<std::size_t>(at - names.begin());
    if (axis > 0 && at->unit != found.unit) return std::nullopt;
    found.unit = at->unit;
  }
  return found;
}

std::optional<PositionNames> find(const std::vector<Name>& names) {
  for (const Triple& wanted : kWhole) {
    const auto found = find(names, [&](std::string_view name, std::size_t axis) { return name == wanted[axis]; });
    if (found) return found;
  }
  for (const auto& [before, behind] : kAround) {
    const auto is_wanted = [&, before = before, behind = behind](std::string_view name, std::size_t axis) {
      constexpr std::string_view kAxes = "xyz";
      return name.size() == before.size() + 1 + behind.size() && name.starts_with(before) && name.ends_with(behind) &&
             name[before.size()] == kAxes[axis];
    };
    if (const auto found = find(names, is_wanted)) return found;
  }
  return std::nullopt;
}

}  // namespace

std::optional<PositionNames> find_position_names(const std::vector<std::string_view>& names) {
  std::vector<Name> whole, without;
  for (const std::string_view name : names) {
    whole.push_back({lower_case(name), std::nullopt});
    without.push_back(without_unit(name));
  }
  const auto found = find(whole);
  return found ? found : find(without);
}

std::optional<LengthUnit> unit_in_words(std::string_view text) {
  const bool has_brackets =
      text.size() > 2 && ((text.front() == '[' && text.back() == ']') || (text.front() == '(' && text.back() == ')'));
  const std::string lower = lower_case(has_brackets ? text.substr(1, text.size() - 2) : text);
  const auto* const found = std::ranges::find(kUnits, std::string_view(lower), &UnitName::name);
  return found == kUnits.end() ? std::nullopt : std::optional(found->unit);
}

bool are_degrees(const std::vector<std::string_view>& names) {
  const auto begins = [&names](std::string_view with) {
    return std::ranges::any_of(names, [with](std::string_view name) { return lower_case(name).starts_with(with); });
  };
  return begins("lat") && (begins("lon") || begins("lng"));
}

}  // namespace segserve::codec
