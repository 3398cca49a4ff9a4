// SPDX-License-Identifier: Apache-2.0
#include "core/codec/text/column_names.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "core/codec/common/header_limits.hpp"
#include "core/codec/common/text_parsing.hpp"

namespace segserve::codec {
namespace {

using Triple = std::array<std::string_view, 3>;

constexpr Triple kPosition{"x", "y", "z"};

bool is_same(std::string_view name, std::string_view lower) {
  return std::ranges::equal(
      name, lower, [](char a, char b) { return (a >= 'A' && a <= 'Z' ? static_cast<char>(a - 'A' + 'a') : a) == b; });
}

/// Where the three names are, in any case.
std::optional<std::array<std::size_t, 3>> find(const std::vector<std::string>& names, const Triple& wanted) {
  std::array<std::size_t, 3> found{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto at = std::ranges::find_if(names, [&](const std::string& name) { return is_same(name, wanted[i]); });
    if (at == names.end()) return std::nullopt;
    found[i] = static_cast<std::size_t>(at - names.begin());
  }
  return found;
}

/// A name, and the unit in brackets behind it.
struct NameWithUnit {
  std::string_view name, unit;
};

/// Takes a unit in brackets, and the spaces in front of it, off a name. A number in brackets is part of the name.
NameWithUnit split_unit(std::string_view name) {
  const bool has_unit = name.ends_with(']') || name.ends_with(')');
  const std::size_t bracket = has_unit ? name.find_first_of("[(") : std::string_view::npos;
  if (bracket == std::string_view::npos) return {name, ""};
  const std::string_view unit = name.substr(bracket);
  if (parse_count(unit.substr(1, unit.size() - 2))) return {name, ""};
  const std::size_t end = name.substr(0, bracket).find_last_not_of(' ');
  return {end == std::string_view::npos ? std::string_view() : name.substr(0, end + 1), unit};
}

/// Gives the usual names to those of the position, and finds their unit, which may stand in brackets behind them.
void rename_position(const std::vector<std::string_view>& units, ColumnNames& out) {
  const auto found = find_position_names({out.names.begin(), out.names.end()});
  if (!found) return;
  const auto [x, y, z] = found->fields;
  const bool is_told = found->unit.unit || !found->unit.doubt.empty();
  out.unit = is_told ? found->unit : unit_of_words({units[x], units[y], units[z]});
  for (std::size_t axis = 0; axis < 3; ++axis) out.names[found->fields[axis]] = kPosition[axis];
}

ColumnNames names_between(std::string_view line, Separator separator) {
  ColumnNames out{{}, separator};
  std::vector<std::string_view> units;
  for (const std::string_view cell : split_cells(line, separator, kMostHeaderFields + 1)) {
    const auto [name, unit] = split_unit(cell);
    const bool is_unit = name.empty() && !cell.empty();
    if (is_unit && separator == Separator::kSpace) {  // It belongs to the name before it.
      if (!units.empty()) units.back() = unit;
      continue;
    }
    out.names.emplace_back(is_unit ? cell : name);
    units.push_back(unit);
  }
  rename_position(units, out);
  return out;
}

Separator separator_of_names(std::string_view line) {
  constexpr std::array<std::pair<char, Separator>, 4> kSeparators{
      {{';', Separator::kSemicolon}, {',', Separator::kComma}, {'\t', Separator::kTab}, {'|', Separator::kBar}}};
  for (const auto& [character, separator] : kSeparators) {
    if (line.find(character) != std::string_view::npos) return separator;
  }
  return Separator::kSpace;
}

}  // namespace

std::optional<std::array<std::size_t, 3>> ColumnNames::position() const { return find(names, kPosition); }

ColumnNames column_names(std::string_view line) {
  const Separator separator = separator_of_names(line);
  ColumnNames names = names_between(line, separator);
  // Tabs may stand beside spaces.
  if (separator == Separator::kTab && !names.position()) return names_between(line, Separator::kSpace);
  return names;
}

}  // namespace segserve::codec
