// SPDX-License-Identifier: Apache-2.0
#include "core/codec/common/field_roles.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "core/base/status_macros.hpp"
#include "core/codec/common/color_names.hpp"
#include "core/codec/common/header_limits.hpp"
#include "core/codec/common/position_names.hpp"
#include "core/codec/common/text_parsing.hpp"

namespace segserve::codec {
namespace {

using Names = std::vector<std::string_view>;
using Triple = std::array<std::size_t, 3>;

/// A field with all channels of a color.
struct VectorName {
  std::string_view name;
  bool is_reversed;
};

constexpr std::array<VectorName, 8> kVectorNames{{{"rgb", false},
                                                  {"rgba", false},
                                                  {"bgr", true},
                                                  {"bgra", true},
                                                  {"color", false},
                                                  {"colors", false},
                                                  {"colour", false},
                                                  {"colours", false}}};

/// The names of fields twice: as they are, and in lower case.
class FieldNames {
 public:
  explicit FieldNames(const std::vector<Field>& fields) {
    for (const Field& field : fields) lower_text_.push_back(lower_case(field.name));
    for (std::size_t i = 0; i < fields.size(); ++i) {
      exact_.push_back(fields[i].name);
      lower_.emplace_back(lower_text_[i]);
    }
  }

  absl::StatusOr<std::optional<std::size_t>> find(std::string_view name) const {
    ASSIGN_OR_RETURN(const auto exact, find_unique(exact_, name));
    return exact ? exact : find_unique(lower_, lower_case(name));
  }
  absl::StatusOr<std::optional<Triple>> find(const std::array<std::string_view, 3>& names) const {
    ASSIGN_OR_RETURN(const auto exact, find_triple(exact_, names));
    return exact ? exact : find_triple(lower_, names);
  }
  const Names& exact() const { return exact_; }

 private:
  std::vector<std::string> lower_text_;
  Names exact_, lower_;
};

absl::Status check_point_numbers(const std::vector<Field>& fields) {
  std::size_t left = kMostPointNumbers;
  for (const Field& field : fields) {
    if (field.count > left) {
      return absl::InvalidArgumentError(fmt::format("a point has more than {} numbers, {} of them in {}",
                                                    kMostPointNumbers, field.count, quoted(field.name)));
    }
    left -= field.count;
  }
  return absl::OkStatus();
}

absl::Status find_position(const std::vector<Field>& fields, const FieldNames& names, FieldRoles& roles) {
  ASSIGN_OR_RETURN(const auto usual, names.find({"x", "y", "z"}));
  if (usual) {
    roles.position = *usual;
  } else if (const auto others = find_position_names(names.exact())) {
    roles.position = others->fields;
    roles.unit = others->unit.unit;
    if (!others->unit.doubt.empty()) {
      const auto name = [&](std::size_t axis) { return quoted(fields[others->fields[axis]].name); };
      return absl::InvalidArgumentError(
          fmt::format("the units of {}, {} and {} differ; give all three the same one", name(0), name(1), name(2)));
    }
  } else if (are_degrees(names.exact())) {
    return absl::InvalidArgumentError(
        "latitudes and longitudes are no coordinates in meters; project them first, for example to UTM");
  } else {
    return absl::InvalidArgumentError("x, y and z must be there");
  }
  for (const std::size_t i : roles.position) {
    if (!fields[i].is_single()) {
      return absl::InvalidArgumentError(fmt::format("{} must be one number for each point", quoted(fields[i].name)));
    }
  }
  return absl::OkStatus();
}

/// Finds a color that is one field of 3 or 4 numbers.
absl::Status find_color_vector(const std::vector<Field>& fields, const FieldNames& names, FieldRoles& roles,
                               std::vector<Warning>& warnings) {
  constexpr std::size_t kWithAlpha = 4;
  for (const auto& [name, is_reversed] : kVectorNames) {
    ASSIGN_OR_RETURN(const auto found, names.find(name));
    if (!found || (fields[*found].count != 3 && fields[*found].count != kWithAlpha)) continue;
    roles.color_vector = found;
    roles.color_vector_is_reversed = is_reversed;
    if (fields[*found].count == kWithAlpha && !name.ends_with('a')) {
      warnings.push_back(
          {WarningReason::kOther,
           fmt::format("the 4 numbers of {} are taken as {}, and the last as alpha, which is "
                       "not used",
                       quoted(fields[*found].name), is_reversed ? "blue, green, red" : "red, green, blue")});
    }
    return absl::OkStatus();
  }
  return absl::OkStatus();
}

absl::Status find_color(const std::vector<Field>& fields, const FieldNames& names, FieldRoles& roles,
                        std::vector<Warning>& warnings) {
  for (const std::string_view name : {"rgb", "rgba"}) {
    ASSIGN_OR_RETURN(const auto found, names.find(name));
    if (!found || !fields[*found].is_single() || size_of(fields[*found].type) < 4) continue;
    roles.packed = found;
    return absl::OkStatus();
  }
  for (const ColorNames& wanted : color_names()) {
    const auto& [red, green, blue] = wanted.names;
    ASSIGN_OR_RETURN(const auto found, names.find({red, green, blue}));
    if (found && std::ranges::all_of(*found, [&fields](std::size_t i) { return fields[i].is_single(); })) {
      roles.channels = found;
      roles.channel_kind = wanted.kind;
      return absl::OkStatus();
    }
  }
  return find_color_vector(fields, names, roles, warnings);
}

void warn_of_unused_colors(const std::vector<Field>& fields, std::vector<Warning>& warnings) {
  std::vector<std::string> unused;
  for (const std::size_t i : fields_like_colors(fields)) unused.push_back(quoted(fields[i].name));
  if (unused.empty()) return;
  warnings.push_back({WarningReason::kColorNotUsed,
                      fmt::format("the cloud has no color: {} cannot be used; rgb or rgba can, as one number of 4 or 8 "
                                  "bytes or as 3 or 4 numbers, or r g b, or red green blue",
                                  fmt::join(unused, ", "))});
}

}  // namespace

std::vector<std::size_t> FieldRoles::color_fields() const {
  if (packed) return {*packed};
  if (channels) return {channels->begin(), channels->end()};
  if (color_vector) return {*color_vector};
  return {};
}

void FieldRoles::drop_color() {
  packed.reset();
  channels.reset();
  color_vector.reset();
}

std::vector<std::size_t> FieldRoles::fields() const {
  std::vector<std::size_t> all(position.begin(), position.end());
  const std::vector<std::size_t> color = color_fields();
  all.insert(all.end(), color.begin(), color.end());
  if (label) all.push_back(*label);
  return all;
}

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return lower;
}

bool has_meaning(std::string_view name) {
  constexpr std::array<std::string_view, 7> kOthers{"x", "y", "z", "rgb", "rgba", "label", "scalar_label"};
  const std::string lower = lower_case(name);
  const auto is_channel = [&lower](const ColorNames& color) {
    return std::ranges::find(color.names, lower) != color.names.end();
  };
  return std::ranges::find(kOthers, lower) != kOthers.end() || std::ranges::any_of(color_names(), is_channel);
}

absl::StatusOr<std::optional<std::size_t>> find_unique(const std::vector<std::string_view>& names,
                                                       std::string_view name) {
  const auto first = std::find(names.begin(), names.end(), name);
  if (first == names.end()) return std::nullopt;
  if (std::find(first + 1, names.end(), name) != names.end()) {
    return absl::InvalidArgumentError(fmt::format("'{}' occurs twice", name));
  }
  return static_cast<std::size_t>(first - names.begin());
}

absl::StatusOr<std::optional<std::array<std::size_t, 3>>> find_triple(const std::vector<std::string_view>& names,
                                                                      const std::array<std::string_view, 3>& wanted) {
  std::array<std::size_t, 3> found{};
  bool complete = true;
  for (std::size_t i = 0; i < 3; ++i) {
    ASSIGN_OR_RETURN(const std::optional<std::size_t> index, find_unique(names, wanted[i]));
    complete = complete && index.has_value();
    found[i] = index.value_or(0);
  }
  if (!complete) return std::nullopt;
  return found;
}

absl::StatusOr<FieldRoles> find_field_roles(const std::vector<Field>& fields, std::vector<Warning>& warnings) {
  RETURN_IF_ERROR(check_point_numbers(fields));
  const FieldNames names(fields);
  FieldRoles roles;
  RETURN_IF_ERROR(find_position(fields, names, roles));
  RETURN_IF_ERROR(find_color(fields, names, roles, warnings));
  if (!roles.has_color()) warn_of_unused_colors(fields, warnings);
  for (const std::string_view wanted : {"label", "scalar_Label"}) {
    ASSIGN_OR_RETURN(const auto found, names.find(wanted));
    if (!found || roles.label) continue;
    if (fields[*found].is_single()) {
      roles.label = found;
    } else {
      warnings.push_back(
          {WarningReason::kLabelNotUsed,
           fmt::format("the labels are not used: {} is more than one number", quoted(fields[*found].name))});
    }
  }
  return roles;
}

}  // namespace segserve::codec
