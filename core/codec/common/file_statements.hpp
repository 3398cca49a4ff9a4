// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "segserve/cloud.hpp"
#include "segserve/codec/labeled_cloud.hpp"
#include "segserve/codec/length_unit.hpp"

namespace segserve::codec {

/// The facts that files of segserve state about their cloud, each in a comment, record or title of its own.
struct FileStatements {
  std::optional<View> view = std::nullopt;        ///< "segserve view ..", see view_statement
  std::optional<LengthUnit> unit = std::nullopt;  ///< "segserve unit mm": that of the coordinates

  /// Notes what a comment states. Returns false if it is no statement.
  bool take(std::string_view comment);
};

/// The statement of a unit, which must not be kAuto.
std::string unit_statement(LengthUnit unit);

/// The statements that a file with this content has: the view, and the unit unless it is the meter.
std::vector<std::string> statements_of(const FileContent& content);

}  // namespace segserve::codec
