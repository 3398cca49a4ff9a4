// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/base/stop_check.hpp"
#include "core/codec/common/column.hpp"
#include "segserve/codec/warning.hpp"

namespace segserve::codec {

/// Names the columns of a table that has none, three at least, by their values:
///
///     x y z                              x y z intensity
///     x y z red green blue               x y z nx ny nz (of length 1)
///     x y z intensity red green blue     the same with a triple of colors or normals, or other values, behind
///     x y z red green blue alpha (full for all points)
///     x y z rgb (integers beyond 16 bits that do not ascend as times do, or their bits as floats)
///
/// Three columns are a color if they look alike: whole numbers or decimals, of one magnitude, none rising from row to
/// row as times do. NaN and -1 are colors that are missing. Where the fourth column and the fifth could both be red, it
/// is the one whose color has bytes, if the other one's has larger numbers.
///
/// A first column of integers that count the rows, before three others at least and no two triples, is the number of
/// the point, as surveyors write it; so it is, whatever its values, if it is known to have the numbers of the rows.
///
/// Two first columns of integers that go through a grid row by row, in front of three with decimals, are the row and
/// the column of each point, as scanners export them.
///
/// A last column of integers up to 64 behind colors that are larger or have decimals is a label, if there are seven or
/// eight columns. Seven columns that can be read in either way else are x y z intensity red green blue, as in PTS, and
/// eight with a label are these with the label behind. Other columns are `column_4` and so on. Warns if the values do
/// not make the meaning plain. Once `check` has stopped, the names mean nothing.
std::vector<std::string> name_columns(const std::vector<Column>& columns, std::size_t points, StopCheck& check,
                                      std::vector<Warning>& warnings, bool has_row_numbers = false);

}  // namespace segserve::codec
