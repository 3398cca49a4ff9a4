// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/stop_check.hpp"
#include "core/codec/common/file_statements.hpp"
#include "core/codec/las/reference_system.hpp"
#include "segserve/codec/attribute.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/codec/warning.hpp"

namespace segserve::codec {

/// Who wrote a variable length record: the records of the specification, and segserve's own, whose payload is one of
/// the statements_of the content. They are numbered in this order.
inline constexpr std::string_view kLasSpecUser = "LASF_Spec", kLasProjectionUser = "LASF_Projection",
                                  kLasStatementUser = "segserve";
inline constexpr std::uint16_t kLasExtraBytesRecord = 4, kLasFirstStatement = 1;
/// The bits of the global encoding: GPS times are standard times, and the reference system is a text.
inline constexpr std::uint16_t kLasStandardGpsTime = 0x1, kLasTextSystem = 0x10;
/// Bytes of the header of a variable length record, of that of an extended one, and of the description of an extra
/// dimension.
inline constexpr std::size_t kLasRecordHeaderBytes = 54, kLasExtendedRecordHeaderBytes = 60,
                             kLasExtraDescriptionBytes = 192;

/// Values that a file has for each point beyond those of its point format ("extra bytes").
struct LasExtra {
  std::string name;
  ScalarType type = ScalarType::kUint8;
  std::size_t count = 1;   ///< numbers for each point
  std::size_t offset = 0;  ///< in the record
  /// The numbers are scale * stored + shift, if the file says so.
  std::optional<std::array<double, 3>> scale, shift;

  bool is_scaled() const { return scale || shift; }
};

/// The contents of the header and of the variable length records of a LAS file.
struct LasHeader {
  unsigned point_format = 0;
  std::size_t record_bytes = 0;
  std::size_t body_offset = 0;
  std::size_t points = 0;  ///< that the file promises and holds, or all that it holds if it promises none
  std::array<double, 3> scale{}, offset{};
  std::vector<LasExtra> extra;
  FileStatements stated;
  bool is_from_segserve = false;
  bool has_standard_gps_time = false;  ///< see LabeledCloud
  ReferenceRecords reference_records;
  std::optional<ReferenceSystem> reference_system;
  std::vector<Warning> warnings;
};

/// Whether a file begins as LAS and LAZ do.
bool is_las(std::string_view file);

/// Parses the header of a LAS file of version 1.0 to 1.4. INVALID_ARGUMENT names what is wrong, or that the file is
/// LAZ. Warns of points that the file promises and does not hold, or holds and does not promise, and of damaged
/// variable length records. The header refers to the file. CANCELLED, DEADLINE_EXCEEDED.
absl::StatusOr<LasHeader> parse_las_header(std::span<const std::byte> file, const DecodeLimits& limits,
                                           StopCheck& check);

}  // namespace segserve::codec
