// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace segserve::eval {

/// The assignment of rows to columns with the largest sum of weights, each column taken at most once, by the Hungarian
/// method (Kuhn 1955, Munkres 1957) in O(rows^2 * columns). `weights` has rows * columns entries, row by row; there are
/// at least as many columns as rows. The result has the column of each row.
std::vector<std::size_t> best_assignment(std::span<const double> weights, std::size_t rows, std::size_t columns);

}  // namespace segserve::eval
