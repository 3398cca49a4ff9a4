// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "core/base/stop_check.hpp"
#include "core/codec/common/point_columns.hpp"
#include "segserve/codec/labeled_cloud.hpp"
#include "segserve/codec/warning.hpp"

// A LAS file describes its coordinates in records of user LASF_Projection ("LAS Specification 1.4 - R15", section
// 3; "GeoTIFF Format Specification 1.0", sections 2.4 and 6).
namespace segserve::codec {

/// The number of the record that has the reference system as a text (WKT).
inline constexpr std::uint16_t kLasTextRecord = 2112;

/// A coordinate reference system, as far as it matters here.
struct ReferenceSystem {
  enum class CoordinateKind : std::uint8_t { kUnknown, kLengths, kDegrees };
  CoordinateKind kind = CoordinateKind::kUnknown;
  std::optional<double> meters_per_unit;  ///< of horizontal lengths; not above 0 if the file names a unit in vain
  std::optional<double> meters_per_height_unit;  ///< the same of heights, if they have a unit of their own
};

/// The records about the reference system, as they are in the file, which must outlive them.
class ReferenceRecords {
 public:
  /// Keeps the payload of a record of user LASF_Projection, unless there was one with this number before. Numbers that
  /// the specification does not have are left out.
  void add(std::uint16_t id, std::span<const std::byte> payload);
  /// Copies of all records, in the order of the file.
  std::vector<ReferenceRecord> copies() const;
  /// Reads the records. `has_text` is whether the header says that the system is a text, which counts if there are
  /// both. Damaged records are not used, with a warning.
  std::optional<ReferenceSystem> read(bool has_text, std::vector<Warning>& warnings) const;

 private:
  struct Record {
    std::uint16_t id;
    std::span<const std::byte> payload;
  };

  std::optional<std::span<const std::byte>> find(std::uint16_t id) const;

  std::vector<Record> records_;
};

/// Applies the system to points whose first three fields are x, y and z: sets the table's reference_unit. Heights are
/// taken in the unit of x and y, with a warning if they have another one. Latitudes and
/// longitudes are INVALID_ARGUMENT, unless the coordinates reach farther than degrees do, which is told in a warning.
absl::Status use_reference_system(const ReferenceSystem& system, StopCheck& check, PointTable& table,
                                  std::vector<Warning>& warnings);

}  // namespace segserve::codec
