// SPDX-License-Identifier: Apache-2.0
#include "core/lab/eval/assignment.hpp"

#include <limits>

namespace segserve::eval {
namespace {

constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

/// The state between rows. Costs are negative weights. The potentials keep every reduced cost at 0 or above, and those
/// of assigned pairs at 0.
class Assignment {
 public:
  Assignment(std::span<const double> weights, std::size_t rows, std::size_t columns)
      : weights_(weights),
        columns_(columns),
        row_potential_(rows),
        column_potential_(columns),
        row_of_(columns, kNone) {}

  /// Assigns one more row along the cheapest augmenting path, which Dijkstra's algorithm finds.
  void add(std::size_t row) {
    std::vector<double> distance(columns_, std::numeric_limits<double>::infinity());
    std::vector<std::size_t> previous(columns_, kNone);
    std::vector<bool> visited(columns_, false);
    std::vector<std::size_t> path;  // the columns visited so far
    std::size_t last = kNone;
    for (std::size_t r = row; r != kNone; r = row_of_[last]) {
      const double so_far = last == kNone ? 0 : distance[last];
      std::size_t next = kNone;
      for (std::size_t c = 0; c < columns_; ++c) {
        if (visited[c]) continue;
        const double length = so_far - weights_[r * columns_ + c] - row_potential_[r] - column_potential_[c];
        if (length < distance[c]) {
          distance[c] = length;
          previous[c] = last;
        }
        if (next == kNone || distance[c] < distance[next]) next = c;
      }
      last = next;
      visited[last] = true;
      path.push_back(last);
    }
    path.pop_back();  // the last column is free
    row_potential_[row] += distance[last];
    for (const std::size_t c : path) {
      row_potential_[row_of_[c]] += distance[last] - distance[c];
      column_potential_[c] -= distance[last] - distance[c];
    }
    for (; previous[last] != kNone; last = previous[last]) row_of_[last] = row_of_[previous[last]];
    row_of_[last] = row;
  }

  const std::vector<std::size_t>& row_of_column() const { return row_of_; }

 private:
  std::span<const double> weights_;
  std::size_t columns_;
  std::vector<double> row_potential_, column_potential_;
  std::vector<std::size_t> row_of_;  // of each column
};

}  // namespace

std::vector<std::size_t> best_assignment(std::span<const double> weights, std::size_t rows, std::size_t columns) {
  Assignment assignment(weights, rows, columns);
  for (std::size_t row = 0; row < rows; ++row) assignment.add(row);
  std::vector<std::size_t> column_of(rows);
  for (std::size_t c = 0; c < columns; ++c) {
    const std::size_t row = assignment.row_of_column()[c];
    if (row != kNone) column_of[row] = c;
  }
  return column_of;
}

}  // namespace segserve::eval
