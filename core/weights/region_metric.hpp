// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/region_graph/region_edge.hpp"

namespace segserve {

/// How dissimilar adjacent regions are, and how that changes when they merge: the part of the method that the paper
/// calls modular. Regions are named by their smallest supervoxel.
///
/// - `Evidence` is what the metric keeps of an edge. Where two edges become one, theirs is added up.
/// - evidence(e) is that of edge e of the region graph, before any merge.
/// - dissimilarity(a, b, evidence) gives the order of the merges. It must be the same bits for (a, b) and (b, a).
/// - weight(dissimilarity) maps it to [0, 1], where it may saturate. It grows with it, up to rounding.
/// - too_small(r) says that a region cannot stay on its own. Merging never makes a region too small.
/// - merge(into, from, evidence) makes one region of two, whose edge has this evidence; `into` is the smaller number.
template <typename T>
concept RegionMetric = requires(T metric, const T& constant, typename T::Evidence evidence, std::uint32_t r, double d,
                                std::size_t e) {
  { constant.region_count() } -> std::convertible_to<std::size_t>;
  { constant.points(r) } -> std::convertible_to<std::uint32_t>;
  { constant.evidence(e) } -> std::convertible_to<typename T::Evidence>;
  { constant.dissimilarity(r, r, evidence) } -> std::convertible_to<double>;
  { constant.weight(d) } -> std::convertible_to<double>;
  { constant.too_small(r) } -> std::convertible_to<bool>;
  metric.merge(r, r, evidence);
  evidence += evidence;
};

/// A metric by which a merge leaves most edges of a large region as they are: that region's part in an edge only counts
/// where counts(region, neighbor), or where changes_all(into, from) says that this merge changes all edges of `into`.
/// Once a region does not count, it does not after its merges, either.
template <typename T>
concept PartialRegionMetric = RegionMetric<T> && requires(const T& constant, std::uint32_t r) {
  { constant.counts(r, r) } -> std::convertible_to<bool>;
  { constant.changes_all(r, r) } -> std::convertible_to<bool>;
};

/// A metric without evidence that computes the dissimilarities of many pairs of regions at once, which is faster than
/// one by one, and that knows those of all edges of the region graph before any merge.
template <typename T>
concept BatchRegionMetric = RegionMetric<T> &&
    requires(const T& constant, std::span<const RegionEdge> pairs, double* dissimilarities) {
  constant.dissimilarities(pairs, dissimilarities);
  { constant.initial_dissimilarities() } -> std::same_as<std::span<const double>>;
};

}  // namespace segserve
