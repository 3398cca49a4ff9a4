#pragma once

#include <cstdint>
#include <vector>

#include "core/math/vec3.hpp"

namespace segserve::synth {

/// Fuses samples of surfaces into one point per cell of a grid, as a volumetric reconstruction does:
/// samples of one cell are averaged, so that noise shrinks and the surface stays thin.
class SurfaceGrid {
 public:
  struct Cell {
    std::uint64_t key;  ///< place in the grid
    float x, y, z;      ///< weighted sum of positions, relative to `origin`
    float weight;
    std::uint32_t rgb;
    std::uint32_t label;
  };

  /// Cells of `spacing` metres; coordinates must be within +-10^6 cells of `origin`.
  SurfaceGrid(double spacing, const Vec3& origin, std::size_t expected_cells);

  /// The cell of a true point of the surface, new if nobody has seen it (then weight is 0). The
  /// reference lasts until the next call.
  Cell& cell(const Vec3& surface_point);
  /// Adds a measured position to a cell.
  void add(Cell& cell, const Vec3& measured, double weight) const;

  /// In the order in which they were first seen.
  const std::vector<Cell>& cells() const { return cells_; }
  /// The mean of a cell's measurements.
  Vec3 position(const Cell& cell) const;

 private:
  void grow();

  double inverse_spacing_;
  Vec3 origin_;
  std::vector<Cell> cells_;
  std::vector<std::uint32_t> slots_;  // open addressing; index in cells_ plus 1, 0 = free
};

}  // namespace segserve::synth
