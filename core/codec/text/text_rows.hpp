// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "core/base/stop_check.hpp"
#include "core/codec/common/column.hpp"
#include "core/codec/common/text_parsing.hpp"
#include "core/codec/text/text_start.hpp"
#include "segserve/codec/decode_limits.hpp"

namespace segserve::codec {

/// Reads the rows of a table into memory, row by row, as doubles. Columns of integers, some of them beyond 2^53, are
/// kept as integers of 64 bits. Cells that are empty, or say that a number is unknown, are NaN.
class TextRows {
 public:
  TextRows(const TextStart& start, const DecodeLimits& limits)
      : start_(start), limits_(limits), promised_(start.count.value_or(0)) {}

  /// Errors name the line.
  absl::Status read(std::string_view file, StopCheck& check);

  std::size_t points() const { return points_; }
  /// The number of rows by the counts above them.
  std::uint64_t promised() const { return promised_; }
  /// Columns with words that are no numbers, and what is wrong with the first such word of each.
  const std::map<std::size_t, std::string>& unreadable() const { return unreadable_; }
  /// Columns in which integers beyond 2^53 are not exact.
  const std::set<std::size_t>& rounded() const { return rounded_; }
  ScalarType type(std::size_t i) const { return column(i).type; }
  Column column(std::size_t i) const;

 private:
  absl::Status make_room(std::string_view rows, StopCheck& check);
  std::optional<std::uint64_t> block_count(std::string_view line) const;
  std::string name_of(std::size_t column) const;
  absl::Status read_row(const LineReader::Line& line);
  absl::Status take_word_without_number(std::size_t line, std::string_view cell, std::size_t column);
  /// The values of a column of integers, as 64 bits each.
  struct Integers {
    std::vector<std::uint64_t> bits;
    bool has_negative = false, has_unsigned = false;  ///< values below 0, and values beyond those of a sign

    /// Adds the integer of a cell. Returns false if it is none, or if no type holds it and those before it.
    bool add(std::string_view cell);
  };

  void keep_integer(std::size_t column, std::string_view cell, double value);
  std::optional<Integers> integers_so_far(std::size_t column) const;

  const TextStart& start_;
  const DecodeLimits& limits_;
  std::vector<double> values_;
  std::size_t points_ = 0;
  std::uint64_t promised_;
  std::map<std::size_t, std::string> unreadable_;
  std::map<std::size_t, Integers> integers_;  // columns with integers beyond 2^53
  std::set<std::size_t> rounded_;
};

}  // namespace segserve::codec
