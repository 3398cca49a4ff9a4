// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <utility>
#include <vector>

#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
#include "core/codec/common/limit_checks.hpp"
#include "core/codec/npy/npy.hpp"
#include "core/codec/npy/npy_array.hpp"
#include "core/codec/npy/npy_points.hpp"
#include "core/codec/npy/npy_table.hpp"

namespace segserve::codec {

absl::StatusOr<LabeledCloud> read_array(const NpyArray& array, std::vector<Warning> warnings,
                                        const DecodeLimits& limits, const ReadOptions& options, const StopToken& stop) {
  if (array.surplus() > 0) {
    warnings.push_back({WarningReason::kRowsNotUsed,
                        fmt::format("{}: {} bytes behind the array are not used", array.name(), array.surplus())});
  }
  StopCheck check(stop);
  NpyTable points(limits, check, warnings);
  const bool is_structured = array.header().is_structured;
  RETURN_IF_ERROR(points.set_shape(array, is_structured ? 0 : 1));
  if (is_structured) {
    points.add_fields(array);
  } else {
    RETURN_IF_ERROR(points.add_unnamed(array));
  }
  RETURN_IF_ERROR(check.status());
  return read_table(points, warnings, options, stop);
}

absl::StatusOr<LabeledCloud> read_table(NpyTable& points, std::vector<Warning>& warnings, const ReadOptions& options,
                                        const StopToken& stop) {
  ASSIGN_OR_RETURN(const PointTable table, points.finish());
  LabeledCloud out;
  out.warnings = std::move(warnings);
  RETURN_IF_ERROR(read_points(table, {}, options, stop, out));
  return out;
}

absl::StatusOr<LabeledCloud> decode_npy(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                        const ReadOptions& options, const StopToken& stop) {
  RETURN_IF_ERROR(check_bytes("NPY file: ", bytes.size(), limits));
  StopCheck check(stop);
  ASSIGN_OR_RETURN(NpyArray array, NpyArray::open(bytes, "NPY file", check));
  RETURN_IF_ERROR(array.put_channels_last(check));
  return read_array(array, {}, limits, options, stop);
}

}  // namespace segserve::codec
