// SPDX-License-Identifier: Apache-2.0
#include "core/codec/las/reference_system.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/codec/common/position_names.hpp"
#include "core/codec/common/text_parsing.hpp"
#include "core/codec/las/well_known_text.hpp"

namespace segserve::codec {
namespace {

using CoordinateKind = ReferenceSystem::CoordinateKind;

constexpr double kSurveyFoot = 1200.0 / 3937;
constexpr std::uint16_t kDirectoryRecord = 34735, kDoublesRecord = 34736, kNamesRecord = 34737, kTransformRecord = 2111;

/// The meters of a unit by its number in the registry of EPSG; 0 for other units.
double meters_of_code(unsigned code) {
  constexpr unsigned kMeter = 9001, kFoot = 9002, kUsSurveyFoot = 9003;
  if (code == kMeter) return 1;
  if (code == kFoot) return meters_per_unit(LengthUnit::kFoot);
  return code == kUsSurveyFoot ? kSurveyFoot : 0;
}

/// An entry of the directory of GeoKeys.
struct GeoKey {
  unsigned id, record, count, value;
};

/// The keys of a directory; nullopt if it holds fewer than it promises.
std::optional<std::vector<GeoKey>> geo_keys(std::span<const std::byte> directory) {
  constexpr std::size_t kKeyBytes = 8, kCount = 6;
  const auto number = [directory](std::size_t offset) { return load<std::uint16_t>(directory.data() + offset); };
  if (directory.size() < kKeyBytes) return std::nullopt;
  const std::size_t count = number(kCount);
  if (directory.size() / kKeyBytes < count + 1) return std::nullopt;
  std::vector<GeoKey> keys;
  for (std::size_t at = kKeyBytes; keys.size() < count; at += kKeyBytes) {
    keys.push_back({number(at), number(at + 2), number(at + 4), number(at + 6)});
  }
  return keys;
}

/// Reads a directory of GeoKeys, and the numbers that it refers to.
std::optional<ReferenceSystem> read_geo_keys(std::span<const std::byte> directory, std::span<const std::byte> doubles) {
  constexpr unsigned kModel = 1024, kUnit = 3076, kUnitSize = 3077, kHeightUnit = 4099, kGeographic = 2, kUndefined = 0;
  const auto keys = geo_keys(directory);
  if (!keys) return std::nullopt;
  ReferenceSystem system;
  for (const GeoKey& key : *keys) {
    const bool is_number = key.record == 0;
    if (key.id == kModel && is_number) {
      system.kind = key.value == kGeographic ? CoordinateKind::kDegrees : CoordinateKind::kLengths;
    } else if (key.id == kUnit && is_number && key.value != kUndefined) {
      system.meters_per_unit = meters_of_code(key.value);
    } else if (key.id == kHeightUnit && is_number && key.value != kUndefined) {
      system.meters_per_height_unit = meters_of_code(key.value);
    } else if (key.id == kUnitSize && key.record == kDoublesRecord) {
      if (doubles.size() / sizeof(double) <= key.value) return std::nullopt;
      system.meters_per_unit = load<double>(doubles.data() + key.value * sizeof(double));
    }
  }
  if (system.kind == CoordinateKind::kUnknown && system.meters_per_unit) system.kind = CoordinateKind::kLengths;
  return system;
}

/// Whether two units are the same up to the last digits with which programs write them.
bool is_near(double meters, double expected) {
  constexpr double kTolerance = 1e-7;
  return std::abs(meters / expected - 1) < kTolerance;
}

/// Words for a unit of so many meters.
std::string words_for(double meters) {
  for (const LengthUnit unit : length_units()) {
    if (is_near(meters, meters_per_unit(unit))) return std::string(name(unit));
  }
  if (is_near(meters, kSurveyFoot)) return "US survey feet";
  return meters > 0 ? fmt::format("a unit of {} m", meters) : "a unit that is not known";
}

/// The unit of so many meters, up to the last digits with which programs write it.
ToldUnit told_unit(double meters) {
  for (const LengthUnit unit : length_units()) {
    if (is_near(meters, meters_per_unit(unit))) return {unit, "as the coordinate reference system says"};
  }
  if (is_near(meters, kSurveyFoot)) {
    return {LengthUnit::kFoot,
            "though the coordinate reference system says US survey feet, which are longer by 2 parts in a million"};
  }
  return {LengthUnit::kMeter, fmt::format("though the coordinate reference system has {}", words_for(meters)), true};
}

/// Warns of heights in another unit than that in which x and y are taken. International and US survey feet are alike.
void warn_of_heights(const ReferenceSystem& system, std::vector<Warning>& warnings) {
  constexpr double kTolerance = 1e-5;
  if (!system.meters_per_height_unit) return;
  const double height = *system.meters_per_height_unit, horizontal = system.meters_per_unit.value_or(1);
  if (height == horizontal || std::abs(height / horizontal - 1) < kTolerance) return;
  warnings.push_back({WarningReason::kUnitGuessed,
                      fmt::format("the heights are taken as {}, as x and y are, though the coordinate reference system "
                                  "has {} for them; save all three in one unit",
                                  name(told_unit(horizontal).unit), words_for(height))});
}

/// The largest magnitude of x and y; nullopt if there are no points.
std::optional<double> reach(const PointTable& table, StopCheck& check) {
  std::optional<double> farthest;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    for_each_value(table.column(axis), table.points(), check, [&farthest](std::size_t, auto value) {
      farthest = std::max(farthest.value_or(0), std::abs(static_cast<double>(value)));
    });
  }
  return farthest;
}

absl::Status refuse_degrees(const PointTable& table, StopCheck& check, std::vector<Warning>& warnings) {
  constexpr double kMostDegrees = 360;
  const auto farthest = reach(table, check);
  RETURN_IF_ERROR(check.status());
  if (!farthest) return absl::OkStatus();
  if (*farthest <= kMostDegrees) return absl::InvalidArgumentError(fmt::format("LAS file: {}", kDegreesAreRefused));
  warnings.push_back({WarningReason::kUnitGuessed,
                      fmt::format("the coordinates are taken as m, though the coordinate reference system has "
                                  "latitudes and longitudes, because they reach to {:.0f}",
                                  *farthest)});
  return absl::OkStatus();
}

}  // namespace

void ReferenceRecords::add(std::uint16_t id, std::span<const std::byte> payload) {
  constexpr std::array<std::uint16_t, 5> kNumbers{kDirectoryRecord, kDoublesRecord, kNamesRecord, kTransformRecord,
                                                  kLasTextRecord};
  if (std::ranges::find(kNumbers, id) != kNumbers.end() && !find(id)) records_.push_back({id, payload});
}

std::vector<ReferenceRecord> ReferenceRecords::copies() const {
  std::vector<ReferenceRecord> all;
  all.reserve(records_.size());
  for (const Record& record : records_) all.push_back({record.id, std::string(as_text(record.payload))});
  return all;
}

std::optional<std::span<const std::byte>> ReferenceRecords::find(std::uint16_t id) const {
  const auto found = std::ranges::find(records_, id, &Record::id);
  if (found == records_.end()) return std::nullopt;
  return found->payload;
}

std::optional<ReferenceSystem> ReferenceRecords::read(bool has_text, std::vector<Warning>& warnings) const {
  constexpr std::size_t kMostText = 65535;  // as much as a record that is not extended can have
  const auto directory = find(kDirectoryRecord), text = find(kLasTextRecord);
  if (!directory && !text) return std::nullopt;
  std::optional<ReferenceSystem> system;
  const bool is_from_text = text && (has_text || !directory);
  if (is_from_text) {
    const bool is_short = text->size() <= kMostText;
    if (is_short) system = parse_well_known_text(without_end_marks(as_text(*text)));
  } else {
    system = read_geo_keys(*directory, find(kDoublesRecord).value_or(std::span<const std::byte>()));
  }
  if (!system) {
    const int record = is_from_text ? kLasTextRecord : kDirectoryRecord;
    warnings.push_back(
        {WarningReason::kRowsNotUsed,
         fmt::format("record {} is damaged, so that the unit of the coordinate reference system is not used", record)});
  }
  return system;
}

absl::Status use_reference_system(const ReferenceSystem& system, StopCheck& check, PointTable& table,
                                  std::vector<Warning>& warnings) {
  if (system.kind == CoordinateKind::kDegrees) return refuse_degrees(table, check, warnings);
  warn_of_heights(system, warnings);
  if (system.kind == CoordinateKind::kLengths && system.meters_per_unit) {
    table.reference_unit = told_unit(*system.meters_per_unit);
  }
  return absl::OkStatus();
}

}  // namespace segserve::codec
