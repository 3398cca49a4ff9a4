#pragma once

#include <cstddef>
#include <cstdint>

namespace segserve::growth {

/// What a turn measures of a voxel, or of the centre of a cluster, scaled by the weights: position, normal, colour. In
/// the order in which lanes read them, four at a time.
struct Feature {
  float px, py, pz, nx, ny, nz, cr, cg, cb;
};

/// All that turns ask of a voxel in one cache line: a seventh off growth of ten million points.
struct alignas(64) Voxel {
  Feature feature;
  float distance;                  ///< to its owner's centre when that took it
  std::uint32_t owner;             ///< a cluster, or kNobody
  std::uint32_t seen;              ///< the last turn that had it among its candidates
  std::uint32_t first, neighbors;  ///< its row of VoxelAdjacency: where it begins, and how many they are
};

/// The distance of VCCS between features that are scaled by their weights.
struct Distance {
  float normal_weight;
  bool colored;  ///< else all colours are 0
};

/// A voxel that is about to change hands, and how far it is from its new owner's centre.
struct Claim {
  std::uint32_t voxel;
  float distance;
};

/// The turn of a cluster: what it may read, and mark as seen.
struct Turn {
  Voxel* voxels;
  const std::uint32_t* neighbor;  ///< as in VoxelAdjacency
  std::size_t neighbors;          ///< how many there are of all voxels together
  std::uint32_t cluster, number;  ///< whose turn it is, and which
};

/// What a kernel found, and how many neighbours it looked at.
struct Found {
  std::size_t count, visits;
};

/// The inner loops of growth, compiled once for each kind of CPU. All give the same bytes.
struct Kernels {
  /// Splits candidates: those that are nearer to the centre than to their owners become claims, whose number is
  /// returned; the others stay, at `kept`, which may be `candidates`. All are seen. `claims` has room for all.
  std::size_t (*find_claims)(const Turn& turn, const Distance& distance, const Feature& centre,
                             const std::uint32_t* candidates, std::size_t count, Claim* claims, std::uint32_t* kept);
  /// Keeps the claims that touch a voxel of the cluster, at `kept`, which may be `claims`, and finds their number;
  /// the others are not seen any more.
  Found (*keep_touching)(const Turn& turn, const Claim* claims, std::size_t count, Claim* kept);
  /// The foreign neighbours of the claims that were not seen yet, each once: their number. `fresh` has room for all
  /// neighbours and one more.
  Found (*find_fresh)(const Turn& turn, const Claim* claims, std::size_t count, std::uint32_t* fresh);
};

/// Those for `cpu_in_use`.
const Kernels& kernels();

}  // namespace segserve::growth
