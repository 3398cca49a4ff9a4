// SPDX-License-Identifier: Apache-2.0
#include "core/codec/common/unnamed_columns.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>

namespace segserve::codec {
namespace {

using Names = std::array<const char*, 3>;
constexpr Names kColor{"red", "green", "blue"}, kNormal{"nx", "ny", "nz"};

class ColumnNamer {
 public:
  ColumnNamer(const std::vector<Column>& columns, std::size_t points, StopCheck& check)
      : columns_(columns), points_(points), check_(check), names_{"x", "y", "z"} {}

  std::vector<std::string> run(std::vector<Warning>& warnings) {
    while (left() > 0) take_next();
    const bool is_plain = columns_.size() <= 4 || columns_.size() == 6 || (columns_.size() == 7 && !is_ambiguous_);
    if (!is_plain) {
      warnings.push_back({WarningReason::kOther,
                          fmt::format("the columns have no names, and are taken as: {}; a first line with their names "
                                      "tells what they are",
                                      fmt::join(names_, " "))});
    }
    return names_;
  }

 private:
  std::size_t left() const { return columns_.size() - names_.size(); }

  void take_next() {
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
    const bool is_label_last = left() == 1 && color_ > 0 && columns_.size() <= 8 && is_label(names_.size(), color_);
    if (is_label_last) {
      names_.emplace_back("label");
      return;
    }
    if (color_ > 0 && names_.size() == color_ + 3 && is_full(names_.size())) {
      names_.emplace_back("alpha");
      return;
    }
    const bool is_intensity = names_.size() == 3 && (left() == 1 || left() >= 4);
    names_.push_back(is_intensity ? "intensity" : fmt::format("column_{}", names_.size() + 1));
  }

  /// Whether the next column is an intensity in front of colors, although it and the two behind it could be colors.
  bool is_intensity_before_color() {
    constexpr std::size_t kIntensity = 3, kColorBehind = 4, kLastBlue = 6, kLabel = 7;
    const bool could_be = names_.size() == kIntensity && (left() == 4 || left() == 5) && is_color(kColorBehind);
    if (!could_be) return false;
    if (left() == 4 && is_full(kLastBlue) && !is_full(kLastBlue - 1)) return false;  // It is an alpha.
    if (left() == 5) return is_label(kLabel, kColorBehind) && !is_label(kLastBlue, kIntensity);
    is_ambiguous_ = true;
    return !is_label(kLastBlue, kIntensity);
  }

  /// Whether all values of a column are full intensity.
  bool is_full(std::size_t column) {
    bool fits = true;
    for_each_value(columns_[column], points_, check_, [&fits](std::size_t, auto value) {
      const auto number = static_cast<double>(value);
      fits = fits && (number == 255 || number == 65535);
    });
    return fits;
  }

  /// Whether the values of a column are small integers, and those of the colors from `color` on are larger or have
  /// decimals.
  bool is_label(std::size_t column, std::size_t color) {
    constexpr double kMostLabel = 64;
    bool fits = true, differs = false;
    for_each_value(columns_[column], points_, check_, [&fits](std::size_t, auto value) {
      const auto number = static_cast<double>(value);
      fits = fits && number >= -1 && number <= kMostLabel && number == std::floor(number);
    });
    for (std::size_t i = color; fits && i < color + 3; ++i) {
      for_each_value(columns_[i], points_, check_, [&differs](std::size_t, auto value) {
        const auto number = static_cast<double>(value);
        differs = differs || number > kMostLabel || number != std::floor(number);
      });
    }
    return fits && differs;
  }

  void append(const Names& names) { names_.insert(names_.end(), names.begin(), names.end()); }

  /// Whether the three columns from `first` on are finite, at least 0, and at most 16 bits.
  bool is_color(std::size_t first) {
    bool fits = true;
    for (std::size_t i = first; i < first + 3; ++i) {
      for_each_value(columns_[i], points_, check_, [&fits](std::size_t, auto value) {
        const auto number = static_cast<double>(value);
        fits = fits && number >= 0 && number <= 65535;
      });
    }
    return fits;
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

  const std::vector<Column>& columns_;
  std::size_t points_;
  StopCheck& check_;
  std::vector<std::string> names_;
  std::size_t color_ = 0;  // the first of the colors; 0 if there are none so far
  bool has_normal_ = false, is_ambiguous_ = false;
};

}  // namespace

std::vector<std::string> name_columns(const std::vector<Column>& columns, std::size_t points, StopCheck& check,
                                      std::vector<Warning>& warnings) {
  return ColumnNamer(columns, points, check).run(warnings);
}

}  // namespace segserve::codec
