// SPDX-License-Identifier: Apache-2.0
#include "core/codec/text/text_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
#include "core/codec/common/limit_checks.hpp"
#include "core/codec/common/point_columns.hpp"
#include "core/codec/common/text_parsing.hpp"
#include "core/codec/common/unnamed_columns.hpp"
#include "core/codec/text/text_rows.hpp"
#include "core/codec/text/text_start.hpp"

namespace segserve::codec {
namespace {

constexpr std::string_view kPrefix = "text table: ";

template <typename... Args>
absl::Status fault(fmt::format_string<Args...> format, Args&&... args) {
  return absl::InvalidArgumentError(std::string(kPrefix) + fmt::format(format, std::forward<Args>(args)...));
}

/// The names of the columns; numbers of columns of words are not looked at.
std::vector<std::string> names_of(const TextStart& start, const TextRows& rows, StopCheck& check,
                                  std::vector<Warning>& warnings) {
  if (!start.names.empty()) return start.names;
  std::vector<Column> columns;
  const std::size_t readable = rows.unreadable().empty() ? start.columns : rows.unreadable().begin()->first;
  for (std::size_t i = 0; i < readable; ++i) columns.push_back(rows.column(i));
  std::vector<std::string> names = name_columns(columns, rows.points(), check, warnings,
                                                start.column_numbers && start.column_numbers->has_row_numbers);
  for (std::size_t i = names.size(); i < start.columns; ++i) names.push_back(fmt::format("column_{}", i + 1));
  return names;
}

absl::StatusOr<PointTable> make_table(const std::vector<std::string>& names, const TextRows& rows,
                                      std::vector<Warning>& warnings) {
  PointTable table;
  for (std::size_t i = 0; i < names.size(); ++i) table.fields.push_back({names[i], rows.type(i)});
  auto roles = find_field_roles(table.fields, warnings);
  if (!roles.ok()) return fault("{}", std::string(roles.status().message()));
  table.roles = *std::move(roles);
  for (const std::size_t axis : table.roles.position) {
    const auto found = rows.unreadable().find(axis);
    if (found != rows.unreadable().end()) return fault("{}", found->second);
  }
  leave_out(rows.unreadable(), table, warnings);
  for (const std::size_t rounded : rows.rounded()) {
    warnings.push_back({WarningReason::kAttributeNotKept,
                        fmt::format("integers beyond 2^53 of {} are rounded, because some values of the column are no "
                                    "integers of 64 bits",
                                    quoted(names[rounded]))});
  }
  table.width = static_cast<std::uint32_t>(rows.points());
  table.height = 1;
  table.column = [&rows](std::size_t i) { return rows.column(i); };
  return table;
}

}  // namespace

absl::StatusOr<LabeledCloud> decode_text_table(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                               const ReadOptions& options, const StopToken& stop) {
  RETURN_IF_ERROR(check_bytes(kPrefix, bytes.size(), limits));
  const std::string_view file = without_end_marks(without_byte_order_mark(as_text(bytes)));
  ASSIGN_OR_RETURN(const TextStart start, find_text_start(file));
  StopCheck check(stop);
  TextRows rows(start, limits);
  RETURN_IF_ERROR(rows.read(file, check));
  LabeledCloud out;
  if (start.count && rows.promised() != rows.points()) {
    out.warnings.push_back({WarningReason::kRowsNotUsed,
                            fmt::format("{} points are promised, and {} are there", rows.promised(), rows.points())});
  }
  if (start.titles > 0) {
    out.warnings.push_back({WarningReason::kRowsNotUsed,
                            fmt::format("{} line{} of words above the names of the columns {} not used", start.titles,
                                        start.titles == 1 ? "" : "s", start.titles == 1 ? "is" : "are")});
  }
  if (start.column_numbers) {
    out.warnings.push_back({WarningReason::kRowsNotUsed,
                            fmt::format("the line {} to {} above the rows is taken as the numbers of the columns",
                                        start.column_numbers->first, start.column_numbers->last)});
  }
  if (start.has_tracks && options.keep_everything) {
    out.warnings.push_back({WarningReason::kAttributeNotKept,
                            fmt::format("the images in which the {} points were seen are not kept", rows.points())});
  }
  const std::vector<std::string> names = names_of(start, rows, check, out.warnings);
  RETURN_IF_ERROR(check.status());
  ASSIGN_OR_RETURN(PointTable table, make_table(names, rows, out.warnings));
  table.roles.unit = start.unit.unit;
  if (!start.unit.doubt.empty()) table.reference_unit = ToldUnit{LengthUnit::kMeter, start.unit.doubt, true};
  table.stated = start.stated;
  RETURN_IF_ERROR(read_points(table, {}, options, stop, out));
  return out;
}

}  // namespace segserve::codec
