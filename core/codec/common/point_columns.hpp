// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "core/codec/common/column.hpp"
#include "core/codec/common/field_roles.hpp"
#include "core/codec/common/file_statements.hpp"
#include "core/codec/view/view_choice.hpp"
#include "segserve/codec/labeled_cloud.hpp"
#include "segserve/codec/read_options.hpp"
#include "segserve/stop_token.hpp"

// How the values of a file become a cloud with labels.
namespace segserve::codec {

/// A unit of the coordinates, and where a file tells it.
struct ToldUnit {
  LengthUnit unit = LengthUnit::kMeter;
  std::string reason = {};  ///< what follows "the coordinates are taken as m, "
  bool is_doubtful = false;
};

/// The values of width * height points, field by field. The columns lie within bytes at hand. A column may have another
/// type than its field, which then holds the column's values, or is only what the file claims for a position or color.
struct PointTable {
  std::vector<Field> fields;
  FieldRoles roles;  ///< indices into `fields`
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  /// The values of a field. Those of a field with a count above 1 begin with the first of them, and lie next to each
  /// other. Fields without a role are asked for only if everything is to be kept.
  std::function<Column(std::size_t field)> column;
  FileStatements stated = {};
  /// The unit of the coordinate reference system, if the file has one that tells it.
  std::optional<ToldUnit> reference_unit = std::nullopt;

  std::size_t points() const { return std::size_t{width} * height; }
};

/// Fields of a text with words that are no numbers, and what is wrong with the first such word of each.
using UnreadableFields = std::map<std::size_t, std::string>;

/// Takes fields that cannot be read out of the table, and warns of each. If one of a color cannot be read, the others
/// become values without a role. Coordinates are not among the fields.
void leave_out(UnreadableFields unreadable, PointTable& table, std::vector<Warning>& warnings);

/// Converts a table to points and labels, with their view and, if they are wanted, the other values as attributes. The
/// view that the options give, and the one that the table states, are added to the evidence. A unit that the file tells
/// is taken unless the options have one: that of a statement, else of the names, else of the reference system. How
/// packed colors are read is told by read_packed_color. Labels that the file has become the attribute `input_label`,
/// too, because files that are written from it have other labels. Adds warnings. CANCELLED, DEADLINE_EXCEEDED.
absl::Status read_points(const PointTable& given, const ViewEvidence& evidence, const ReadOptions& options,
                         const StopToken& stop, LabeledCloud& out);

}  // namespace segserve::codec
