// SPDX-License-Identifier: Apache-2.0
#include "core/codec/common/position_names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "core/codec/common/field_roles.hpp"
#include "core/codec/common/text_parsing.hpp"

namespace segserve::codec {
namespace {

using Triple = std::array<std::string_view, 3>;

constexpr std::array<Triple, 26> kWhole{{
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
    {"easting", "northing", "elev"},
    {"easting", "northing", "z"},
    {"easting", "northing", "h"},
    {"east", "north", "elev"},
    {"east", "north", "up"},
    {"e", "n", "u"},
    {"rechtswert", "hochwert", "höhe"},
    {"e", "n", "z"},
    {"e", "n", "h"},
    {"x", "y", "height"},
    {"x", "y", "elevation"},
    {"x", "y", "elev"},
    {"x", "y", "altitude"},
    {"x", "y", "h"},
    {"x1", "y1", "z1"},  // of the first return, as Ouster writes it
    {"x_1", "y_1", "z_1"},
}};

/// Each pair is the text before and behind the letter x, y or z of a name.
constexpr std::array<std::pair<std::string_view, std::string_view>, 38> kAround{{
    {"pos_", ""},    {"pos.", ""},   {"position_", ""}, {"position.", ""},   {"point_", ""},      {"point.", ""},
    {"points_", ""}, {"coord_", ""}, {"coord.", ""},    {"coordinate_", ""}, {"field.", ""},      {"world_", ""},
    {"map_", ""},    {"utm_", ""},   {"local_", ""},    {"global_", ""},     {"lidar_", ""},      {"laser_", ""},
    {"camera_", ""}, {"cam_", ""},   {"sensor_", ""},   {"pos", ""},         {"position", ""},    {"p", ""},
    {"ori_", ""},    {"", "_coord"}, {"", " coord"},    {"", "_coordinate"}, {"", " coordinate"}, {"", "_cam"},
    {"", "_camera"}, {"", "_lidar"}, {"", "_sensor"},   {"", "_world"},      {"", "_map"},        {"", "_local"},
    {"", "_global"}, {"", "_utm"},
}};

struct UnitName {
  std::string_view name;
  LengthUnit unit;
};
/// In small letters, without spaces, points, hyphens and underscores.
constexpr std::array<UnitName, 35> kUnits{{
    {"m", LengthUnit::kMeter},
    {"meter", LengthUnit::kMeter},
    {"meters", LengthUnit::kMeter},
    {"metre", LengthUnit::kMeter},
    {"metres", LengthUnit::kMeter},
    {"cm", LengthUnit::kCentimeter},
    {"centimeter", LengthUnit::kCentimeter},
    {"centimeters", LengthUnit::kCentimeter},
    {"centimetre", LengthUnit::kCentimeter},
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
    {"ift", LengthUnit::kFoot},
    {"internationalfoot", LengthUnit::kFoot},
    {"internationalfeet", LengthUnit::kFoot},
    // US survey feet, which are longer by 2 parts in a million.
    {"usft", LengthUnit::kFoot},
    {"ftus", LengthUnit::kFoot},
    {"usfoot", LengthUnit::kFoot},
    {"usfeet", LengthUnit::kFoot},
    {"footus", LengthUnit::kFoot},
    {"surveyft", LengthUnit::kFoot},
    {"surveyfoot", LengthUnit::kFoot},
    {"surveyfeet", LengthUnit::kFoot},
    {"ussurveyft", LengthUnit::kFoot},
    {"ussurveyfoot", LengthUnit::kFoot},
    {"ussurveyfeet", LengthUnit::kFoot},
}};

/// A name and its unit are joined by one of these. Behind an underscore only short names of units count, because words
/// such as x_in and x_foot may be names of their own.
constexpr std::array<std::string_view, 3> kBeforeUnit{"_", "/", " in "};
constexpr std::array<std::string_view, 8> kShortUnits{"m", "cm", "mm", "ft", "usft", "ftus", "us_ft", "survey_ft"};

/// A name in small letters, and the unit behind it, which is not part of it.
struct Name {
  std::string text;
  std::optional<LengthUnit> unit;
};

Name without_unit(std::string_view name) {
  const std::string lower = lower_case(name);
  for (const std::string_view between : kBeforeUnit) {
    // The unit is the longest one that the name ends with.
    for (std::size_t end = lower.find(between, 1); end != std::string::npos; end = lower.find(between, end + 1)) {
      const std::string_view behind = std::string_view(lower).substr(end + between.size());
      if (between == "_" && std::ranges::find(kShortUnits, behind) == kShortUnits.end()) continue;
      if (const auto unit = unit_in_words(behind)) return {lower.substr(0, end), unit};
    }
  }
  return {lower, std::nullopt};
}

/// The unit that x, y and z have in common. One without a unit may be in meters.
TextUnit common_unit(const std::array<std::optional<LengthUnit>, 3>& units) {
  if (units[0] == units[1] && units[0] == units[2]) return {units[0], ""};
  const auto is_meter_or_none = [](const auto& unit) {
    return unit.value_or(LengthUnit::kMeter) == LengthUnit::kMeter;
  };
  if (std::ranges::all_of(units, is_meter_or_none)) return {LengthUnit::kMeter, ""};
  std::array<std::string, 3> said;
  std::ranges::transform(units, said.begin(),
                         [](const auto& unit) { return std::string(unit ? name(*unit) : "none"); });
  return {std::nullopt, fmt::format("though the units of x, y and z differ: {}", fmt::join(said, ", "))};
}

/// Where three names are that `is_wanted(name, axis)` accepts.
template <typename IsWanted>
std::optional<PositionNames> find(const std::vector<Name>& names, IsWanted is_wanted) {
  PositionNames found;
  std::array<std::optional<LengthUnit>, 3> units;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto at = std::ranges::find_if(names, [&](const Name& name) { return is_wanted(name.text, axis); });
    if (at == names.end()) return std::nullopt;
    found.fields[axis] = static_cast<std::size_t>(at - names.begin());
    units[axis] = at->unit;
  }
  found.unit = common_unit(units);
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

/// The text with a u in place of either letter that stands for micro, which messages could not show.
std::string with_plain_micro(std::string_view text) {
  std::string plain(text);
  for (const std::string_view micro : {"µ", "μ"}) {
    const std::size_t at = plain.find(micro);
    if (at == std::string::npos) continue;
    plain[at] = 'u';
    plain.erase(at + 1, micro.size() - 1);
  }
  return plain;
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

std::string_view without_brackets(std::string_view text) {
  const bool has_brackets =
      text.size() >= 2 && ((text.front() == '[' && text.back() == ']') || (text.front() == '(' && text.back() == ')'));
  return has_brackets ? text.substr(1, text.size() - 2) : text;
}

std::optional<LengthUnit> unit_in_words(std::string_view text) {
  constexpr std::size_t kLongest = 64;
  text = without_brackets(text);
  if (text.size() > kLongest) return std::nullopt;
  std::string word = lower_case(text);
  std::erase_if(word, [](char c) { return c == ' ' || c == '.' || c == '-' || c == '_'; });
  const auto* const found = std::ranges::find(kUnits, std::string_view(word), &UnitName::name);
  return found == kUnits.end() ? std::nullopt : std::optional(found->unit);
}

TextUnit unit_of_words(const std::array<std::string_view, 3>& texts) {
  constexpr std::string_view kAxes = "xyz";
  std::array<std::optional<LengthUnit>, 3> units;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string_view text = without_brackets(texts[axis]);
    units[axis] = unit_in_words(text);
    if (units[axis] || text.empty()) continue;
    const std::string shown = quoted(with_plain_micro(text));
    return {std::nullopt, fmt::format("because the unit {} of {} is not known", shown, kAxes[axis])};
  }
  return common_unit(units);
}

bool are_degrees(const std::vector<std::string_view>& names) {
  const auto begins = [&names](std::string_view with) {
    return std::ranges::any_of(names, [with](std::string_view name) { return lower_case(name).starts_with(with); });
  };
  return begins("lat") && (begins("lon") || begins("lng"));
}

}  // namespace segserve::codec
