// SPDX-License-Identifier: Apache-2.0
#include "core/codec/common/color_channels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace segserve::codec {
namespace {

/// The smallest and the largest value that is finite, whether all of these are multiples of 256, or whole, and whether
/// there are others that are NaN.
struct ChannelRange {
  double smallest = 0, largest = 0;
  bool multiples_of_256 = true, is_whole = true, has_nan = false;
};

void extend(ChannelRange& range, const Column& column, std::size_t points, StopCheck& check) {
  for_each_value(column, points, check, [&range](std::size_t /*i*/, auto value) {
    const auto number = static_cast<double>(value);
    range.has_nan = range.has_nan || std::isnan(number);
    if (!std::isfinite(number)) return;
    range.smallest = std::min(range.smallest, number);
    range.largest = std::max(range.largest, number);
    range.multiples_of_256 = range.multiples_of_256 && std::fmod(number, 256) == 0;
    range.is_whole = range.is_whole && number == std::floor(number);
  });
}

/// The factor that makes full intensity 255. Floats up to about 1 have 1 as full intensity, and so have numbers with
/// decimals whose file claims that they are integers. Far above 255 it is 65535, as in LAS files; some writers multiply
/// 8 bits by 256 instead of 257. A little above 255, and beyond 16 bits, a value is taken as a slip among bytes, and
/// clamped.
double channel_scale(const ChannelRange& range, bool are_floats) {
  constexpr double kAboutOne = 1.5, kFarAboveBytes = 1023, kSixteenBits = 65535;
  if ((are_floats || !range.is_whole) && range.largest <= kAboutOne) return 255;
  if (range.largest <= kFarAboveBytes || range.largest > kSixteenBits) return 1;
  return range.multiples_of_256 ? 1.0 / 256 : 1.0 / 257;
}

/// Whether the values are -1 to 1, with 0 as half intensity. A little below 0 is a slip.
bool are_signed_units(const ChannelRange& range, bool are_floats) {
  constexpr double kLeast = -1.01, kSlip = -0.1, kMost = 1.01;
  return (are_floats || !range.is_whole) && range.smallest >= kLeast && range.smallest < kSlip &&
         range.largest <= kMost;
}

void warn_of_range(const ChannelRange& range, double full, std::size_t values, std::size_t clamped,
                   std::vector<Warning>& warnings) {
  constexpr double kDark = 10;
  if (clamped > values / 100) {
    warnings.push_back({WarningReason::kColorNotUsed,
                        fmt::format("{} of {} color values are beyond 0 to {}, which is taken as full intensity, and "
                                    "are clamped; they reach from {:.4g} to {:.4g}",
                                    clamped, values, full, range.smallest, range.largest)});
  } else if (full > 255 && range.largest < full / kDark) {
    warnings.push_back({WarningReason::kColorNotUsed,
                        fmt::format("the colors reach only {:.4g} of {:.0f}, and are nearly black; values of 12 bits "
                                    "must be multiplied by 16",
                                    range.largest, full)});
  } else if (full == 255 && !range.is_whole && range.largest < kDark) {
    warnings.push_back({WarningReason::kColorNotUsed,
                        fmt::format("the colors reach only {:.4g} of 255, and are nearly black; 0 to 1 would be "
                                    "another range",
                                    range.largest)});
  }
}

/// Rounds to 0 to 255. NaN becomes 0.
std::uint32_t to_channel(double value) {
  if (!(value > 0)) return 0;  // The comparison is false for NaN.
  return value < 255 ? static_cast<std::uint32_t>(std::lround(value)) : 255;
}

/// Sets one of the three bytes of each color, which must be 0 before.
template <typename Convert>
void read_channel(const Column& column, unsigned shift, StopCheck& check, std::vector<std::uint32_t>& out,
                  Convert convert) {
  for_each_value(column, out.size(), check, [&](std::size_t i, auto value) { out[i] |= convert(value) << shift; });
}

/// Whether the values of the channel are bytes. Those of a signed type are the same eight bits.
bool is_byte(const Column& column) { return size_of(column.type) == 1; }

}  // namespace

MissingColorSigns read_channels(const Channels& columns, ChannelKind kind, std::optional<ScalarType> claimed,
                                StopCheck& check, std::vector<std::uint32_t>& out, std::vector<Warning>& warnings) {
  constexpr std::array<unsigned, 3> kShifts{16, 8, 0};
  if (kind == ChannelKind::kIntensity && std::ranges::all_of(columns, is_byte)) {
    for (std::size_t i = 0; i < 3; ++i) {
      read_channel(columns[i], kShifts[i], check, out,
                   [](auto value) { return std::uint32_t{static_cast<std::uint8_t>(value)}; });
    }
    return {};
  }
  MissingColorSigns signs;
  constexpr double kY = 0.28209479177387814;  // sqrt(1 / (4 pi))
  double scale = 255 * kY, offset = 255 * 0.5;
  ChannelRange range;
  if (kind == ChannelKind::kIntensity) {
    for (const Column& column : columns) extend(range, column, out.size(), check);
    if (claimed == ScalarType::kInt8 && range.is_whole && range.smallest < 0 && range.largest <= 127) {
      for (std::size_t i = 0; i < 3; ++i) {
        read_channel(columns[i], kShifts[i], check, out,
                     [](auto value) { return std::uint32_t{static_cast<std::uint8_t>(static_cast<int>(value))}; });
      }
      return {};
    }
    const bool are_floats = claimed && is_float(*claimed);
    const bool are_signed = are_signed_units(range, are_floats);
    scale = are_signed ? 255 * 0.5 : channel_scale(range, are_floats);
    offset = are_signed ? 255 * 0.5 : 0;
    signs = {.is_nan = range.has_nan, .is_minus_one = !are_signed && range.smallest == -1};
  } else if (kind == ChannelKind::kSixteenBits) {
    scale = 1.0 / 257;
    offset = 0;
  }
  constexpr double kSlip = 2;
  std::size_t values = 0, clamped = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    read_channel(columns[i], kShifts[i], check, out, [scale, offset, &values, &clamped](auto value) {
      const double intensity = static_cast<double>(value) * scale + offset;
      values += std::isfinite(intensity) ? 1 : 0;
      clamped += intensity < -kSlip || intensity > 255 + kSlip ? 1 : 0;
      return to_channel(intensity);
    });
  }
  if (kind == ChannelKind::kIntensity) warn_of_range(range, 255 / scale, values, clamped, warnings);
  return signs;
}

void warn_of_missing_channels(const Channels& channels, MissingColorSigns signs, const Cloud& cloud, StopCheck& check,
                              std::vector<Warning>& warnings) {
  const auto warn_of = [&](const char* sign, auto is_missing) {
    std::vector<std::uint8_t> missing(cloud.size(), 0);  // channels of each point
    for (const Column& channel : channels) {
      for_each_value(channel, missing.size(), check, [&](std::size_t i, auto value) {
        missing[i] = static_cast<std::uint8_t>(missing[i] + (is_missing(static_cast<double>(value)) ? 1 : 0));
      });
    }
    std::size_t colors = 0, points = 0;
    check.for_each(0, missing.size(), [&](std::size_t i) {
      if (!is_finite(cloud.x[i], cloud.y[i], cloud.z[i])) return;
      ++points;
      colors += missing[i] == channels.size() ? 1 : 0;
    });
    warn_of_missing_colors(colors, points, sign, warnings);
  };
  if (signs.is_nan) warn_of("NaN", [](double value) { return std::isnan(value); });
  if (signs.is_minus_one) warn_of("-1", [](double value) { return value == -1; });
}

void warn_of_missing_colors(std::size_t missing, std::size_t points, const char* sign, std::vector<Warning>& warnings) {
  if (missing == 0) return;
  warnings.push_back(
      {WarningReason::kColorNotUsed, fmt::format("{} of {} colors are {}, and become black", missing, points, sign)});
}

}  // namespace segserve::codec
