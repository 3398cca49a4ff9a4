// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/math/vec3.hpp"

namespace segserve::synth {

/// Fuses samples of surfaces into one point per cell of a grid, as a volumetric reconstruction does. The samples of a
/// cell are averaged, so that noise shrinks and the surface stays thin.
class SurfaceGrid {
 public:
  struct Cell {
    std::uint64_t key;  ///< Position in the grid.
    float x, y, z;      ///< Weighted sum of the measured positions, relative to `origin`.
    float weight;
    std::uint32_t rgb;
    std::uint32_t label;
  };

  /// Cells are cubes of `spacing` meters. Coordinates must be within 10^6 cells of `origin`.
  SurfaceGrid(double spacing, const Vec3& origin, std::size_t expected_cells);

  /// The cell that holds a true point of the surface. A new cell has weight 0. The reference is valid until the next
  /// call.
  Cell& find_or_add(const Vec3& surface_point);
  /// Adds a measured position to a cell.
  void add(Cell& cell, const Vec3& measured, double weight) const;

  /// All cells, in the order in which they were found.
  const std::vector<Cell>& cells() const { return cells_; }
  /// The weighted mean of the measurements of a cell.
  Vec3 position(const Cell& cell) const;

 private:
  void grow();

  double inverse_spacing_;
  Vec3 origin_;
  std::vector<Cell> cells_;
  std::vector<std::uint32_t> slots_;  // hash table with open addressing: index in cells_ plus 1, or 0 for a free slot
};

}  // namespace segserve::synth
