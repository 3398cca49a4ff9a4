// SPDX-License-Identifier: Apache-2.0
#include "core/codec/common/unnamed_columns.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "core/codec/common/color_evidence.hpp"

namespace segserve::codec {
namespace {

using Names = std::array<const char*, 3>;
constexpr Names kColor{"red", "green", "blue"}, kNormal{"nx", "ny", "nz"};

/// Whether the values are integers, each by one larger than that of the point before it.
bool counts_rows(const Column& column, std::size_t points, StopCheck& check) {
  constexpr std::size_t kFewest = 3;
  if (points < kFewest) return false;
  bool fits = true;
  double last = 0;
  for_each_value(column, points, check, [&](std::size_t i, auto value) {
    const auto number = static_cast<double>(value);
    fits = fits && number == std::floor(number) && (i == 0 || number == last + 1);
    last = number;
  });
  return fits;
}

class ColumnNamer {
 public:
  /// There are so many columns `before` these.
  ColumnNamer(std::span<const Column> columns, std::size_t before, std::size_t points, StopCheck& check)
      : columns_(columns), before_(before), points_(points), check_(check), names_{"x", "y", "z"} {}

  std::vector<std::string> run() {
    while (left() > 0) take_next();
    return names_;
  }

  /// Whether the number of the columns alone makes their meaning plain, and their values agree with it.
  bool is_plain() {
    const bool has_guess = std::ranges::any_of(
        names_, [](const auto& name) { return name == "rgb" || name == "label" || name.starts_with("column_"); });
    if (has_guess || is_ambiguous_) return false;
    if (columns_.size() == 4 || columns_.size() == 7) return !rises_with_rows(0);  // It may be a time, and x behind it.
    return columns_.size() == 3 || columns_.size() == 6;
  }

 private:
  std::size_t left() const { return columns_.size() - names_.size(); }

  void take_next() {
    if (names_.size() == 3 && are_packed_colors(3)) {
      names_.emplace_back("rgb");
      return;
    }
    if (left() >= 3 && !has_normal_ && is_normal(names_.size())) {
      has_normal_ = true;
      return append(kNormal);
    }
    if (left() >= 3 && color_ == 0 && is_color(names_.size())) {
      if (!is_intensity_before_color()) {
        color_ = names_.size();
        return append(kColor);
      }
    }
    if (color_ > 0 && names_.size() == color_ + 3 && is_alpha(names_.size())) {
      names_.emplace_back("alpha");
      return;
    }
    const bool is_label_last = left() == 1 && color_ > 0 && columns_.size() <= 8 && is_label(names_.size(), color_);
    if (is_label_last) {
      names_.emplace_back("label");
      return;
    }
    const bool is_intensity = names_.size() == 3 && (left() == 1 || left() >= 4);
    names_.push_back(is_intensity ? "intensity" : fmt::format("column_{}", before_ + names_.size() + 1));
  }

  /// Whether the next column is an intensity in front of colors, although it and the two behind it could be colors.
  bool is_intensity_before_color() {
    constexpr std::size_t kIntensity = 3, kColorBehind = 4, kLastBlue = 6, kLabel = 7;
    const bool could_be = names_.size() == kIntensity && (left() == 4 || left() == 5) && is_color(kColorBehind);
    if (!could_be) return false;
    if (left() == 4 && is_full(kLastBlue) && !is_full(kLastBlue - 1)) return false;  // It is an alpha.
    const bool are_bytes_here = are_bytes(kIntensity), are_bytes_behind = are_bytes(kColorBehind);
    if (are_bytes_here != are_bytes_behind) {
      is_ambiguous_ = true;
      return are_bytes_behind;
    }
    if (left() == 5) return is_label(kLabel, kColorBehind) && !is_label(kLastBlue, kIntensity);
    is_ambiguous_ = true;
    return !is_label(kLastBlue, kIntensity);
  }

  bool are_packed_colors(std::size_t column) {
    PackedColorEvidence evidence;
    for_each_value(columns_[column], points_, check_,
                   [&evidence](std::size_t, auto value) { evidence.take(static_cast<double>(value)); });
    return evidence.are_colors();
  }

  /// Whether all values of a column are full intensity.
  bool is_full(std::size_t column) {
    return are_all(column, [](double value) { return value == 255 || value == 65535; });
  }

  /// Whether the column behind the colors is full intensity, in the range that they have.
  bool is_alpha(std::size_t column) {
    if (is_full(column)) return true;
    bool are_fractions = are_all(column, [](double value) { return value == 1; });
    for (std::size_t i = color_; are_fractions && i < color_ + 3; ++i) {
      are_fractions = are_all(i, [](double value) { return value <= 1; });
    }
    return are_fractions;
  }

  /// Whether the values of the three columns from `first` on are at most 255.
  bool are_bytes(std::size_t first) {
    bool fits = true;
    for (std::size_t i = first; i < first + 3; ++i) {
      fits = fits && are_all(i, [](double value) { return !(value > 255); });
    }
    return fits;
  }

  template <typename Predicate>
  bool are_all(std::size_t column, Predicate fits_one) {
    bool fits = true;
    for_each_value(columns_[column], points_, check_,
                   [&](std::size_t, auto value) { fits = fits && fits_one(static_cast<double>(value)); });
    return fits;
  }

  /// Whether the values of a column are small integers, and those of the colors from `color` on are larger or have
  /// decimals.
  bool is_label(std::size_t column, std::size_t color) {
    constexpr double kMostLabel = 64;
    bool differs = false;
    const bool fits =
        are_all(column, [](double value) { return value >= -1 && value <= kMostLabel && value == std::floor(value); });
    for (std::size_t i = color; fits && i < color + 3; ++i) {
      for_each_value(columns_[i], points_, check_, [&differs](std::size_t, auto value) {
        const auto number = static_cast<double>(value);
        differs = differs || number > kMostLabel || number != std::floor(number);
      });
    }
    return fits && differs;
  }

  void append(const Names& names) { names_.insert(names_.end(), names.begin(), names.end()); }

  /// Whether the three columns from `first` on look like the channels of one color.
  bool is_color(std::size_t first) {
    std::array<ChannelEvidence, 3> channels;
    for (std::size_t i = 0; i < channels.size(); ++i) {
      for_each_value(columns_[first + i], points_, check_,
                     [&channel = channels[i]](std::size_t, auto value) { channel.take(static_cast<double>(value)); });
      if (channels[i].rises_with_rows(points_)) return false;
    }
    return are_channels(channels, first + channels.size() == columns_.size());
  }

  /// Whether each value of a column is larger than that of the point before it, as times are.
  bool rises_with_rows(std::size_t column) {
    ChannelEvidence evidence;
    for_each_value(columns_[column], points_, check_,
                   [&evidence](std::size_t, auto value) { evidence.take(static_cast<double>(value)); });
    return evidence.rises_with_rows(points_);
  }

  /// Whether the three columns from `first` on have length 1, but for some that are 0 or not finite.
  bool is_normal(std::size_t first) {
    constexpr double kTolerance = 0.02;
    std::vector<double> squares(points_, 0);
    for (std::size_t i = first; i < first + 3; ++i) {
      for_each_value(columns_[i], points_, check_, [&squares](std::size_t point, auto value) {
        squares[point] += static_cast<double>(value) * static_cast<double>(value);
      });
    }
    std::size_t unit = 0, other = 0;
    check_.for_each(0, points_, [&](std::size_t i) {
      if (squares[i] == 0 || !std::isfinite(squares[i])) return;
      ++(std::abs(squares[i] - 1) < kTolerance ? unit : other);
    });
    return unit > 0 && other == 0;
  }

  std::span<const Column> columns_;
  std::size_t before_, points_;
  StopCheck& check_;
  std::vector<std::string> names_;
  std::size_t color_ = 0;  // the first of the colors; 0 if there are none so far
  bool has_normal_ = false, is_ambiguous_ = false;
};

/// Whether the first two columns are the row and the column of each point in a grid, in either order, as scanners
/// export them: whole numbers that go through the grid row by row, in front of coordinates with decimals.
bool begins_with_grid(std::span<const Column> columns, std::size_t points, StopCheck& check) {
  constexpr std::size_t kFewest = 12;
  constexpr double kMostCells = 100'000;
  if (columns.size() < 5 || points < kFewest) return false;
  std::vector<double> outer(points);
  bool fits = true;
  for_each_value(columns[0], points, check, [&](std::size_t i, auto value) {
    outer[i] = static_cast<double>(value);
    fits = fits && outer[i] >= 0 && outer[i] <= kMostCells && outer[i] == std::floor(outer[i]);
  });
  double last = -1;
  std::size_t returns = 0;
  for_each_value(columns[1], points, check, [&](std::size_t i, auto value) {
    const auto inner = static_cast<double>(value);
    fits = fits && inner >= 0 && inner <= kMostCells && inner == std::floor(inner);
    if (i > 0) {
      const bool is_next = outer[i] == outer[i - 1] && inner > last;
      const bool returns_here = outer[i] > outer[i - 1];
      fits = fits && (is_next || returns_here);
      returns += returns_here && inner < last ? 1 : 0;
    }
    last = inner;
  });
  for (std::size_t axis = 2; axis < 5 && fits; ++axis) {
    bool has_decimals = false;
    for_each_value(columns[axis], points, check, [&](std::size_t, auto value) {
      const auto number = static_cast<double>(value);
      has_decimals = has_decimals || (std::isfinite(number) && number != std::floor(number));
    });
    fits = has_decimals;
  }
  // A map of heights has normals behind x, y and z.
  return fits && returns > 0 && ColumnNamer(columns, 0, points, check).run()[3] != kNormal[0];
}

/// Whether the first column has the numbers of the points. Coordinates may count the rows, too, if a triple of colors
/// or normals follows the three of them.
bool begins_with_numbers(std::span<const Column> columns, std::size_t points, StopCheck& check) {
  constexpr std::size_t kTwoTriples = 6;
  if (!counts_rows(columns[0], points, check)) return false;
  return columns.size() != kTwoTriples || ColumnNamer(columns, 0, points, check).run().back() == "column_6";
}

}  // namespace

std::vector<std::string> name_columns(const std::vector<Column>& columns, std::size_t points, StopCheck& check,
                                      std::vector<Warning>& warnings, bool has_row_numbers) {
  const std::span<const Column> all = columns;
  std::vector<std::string> names;
  if (all.size() > 3 && (has_row_numbers || begins_with_numbers(all, points, check))) {
    names = {"point_number"};
  } else if (begins_with_grid(all, points, check)) {
    names = {"row", "column"};
  }
  const std::size_t before = names.size();
  ColumnNamer namer(all.subspan(before), before, points, check);
  const std::vector<std::string> others = namer.run();
  names.insert(names.end(), others.begin(), others.end());
  if (before > 0 || !namer.is_plain()) {
    warnings.push_back({WarningReason::kOther,
                        fmt::format("the columns have no names, and are taken as: {}; a first line with their names "
                                    "tells what they are",
                                    fmt::join(names, " "))});
  }
  return names;
}

}  // namespace segserve::codec
