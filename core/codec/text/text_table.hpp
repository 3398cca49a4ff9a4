// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/codec/text/text_cells.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/codec/labeled_cloud.hpp"
#include "segserve/codec/read_options.hpp"
#include "segserve/stop_token.hpp"

// Tables of numbers in text: XYZ, PTS, CSV and their like.
namespace segserve::codec {

/// What a text is, by its first lines.
enum class TableKind : std::uint8_t {
  kNone,
  kPoints,    ///< numbers, a count with numbers behind it, or names of columns, x, y and z among them
  kNoPoints,  ///< other names of columns with numbers behind them: a table, but x, y and z are not known
};
TableKind table_kind(std::string_view file);

/// Whether a text is a table of any kind. decode_text_table tells what is wrong with one that has no points.
bool is_text_table(std::string_view file);

/// Decodes a table. Cells are separated by spaces, tabs, commas, semicolons or bars, which the first rows tell. Lines
/// that begin with # or // are comments, and above the rows also those that begin with %, ! or ;. The names of the
/// columns stand in the first line, or in the last comment above the rows if it has x, y and z and as many words as a
/// row; else the values tell what the columns are (name_columns). A first line with a single count is that of PTS,
/// which may have several blocks, each with a count. Coordinates are doubles. Comments may be statements of segserve.
/// INVALID_ARGUMENT names the line of what is missing, too much, or no number; CANCELLED, DEADLINE_EXCEEDED.
absl::StatusOr<LabeledCloud> decode_text_table(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                               const ReadOptions& options = {}, const StopToken& stop = {});

/// Encodes a cloud as a table: with commas and the names of the columns in a line (CSV), or with spaces and the names
/// in a comment (XYZ). The lines above it are comments with the statements_of the content. Numbers are the shortest
/// that read back as the same values.
std::string encode_text_table(const FileContent& content, Separator separator);

}  // namespace segserve::codec
