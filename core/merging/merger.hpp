#pragma once

#include <algorithm>
#include <concepts>
#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/stop_check.hpp"
#include "core/merging/below_threshold.hpp"
#include "core/merging/merge_candidate.hpp"
#include "core/merging/merge_tree_builder.hpp"
#include "core/merging/tournament.hpp"
#include "core/region_graph/region_graph.hpp"
#include "segserve/merge_tree.hpp"
#include "segserve/stop_token.hpp"

namespace segserve {

/// What the paper calls modular: how unlike two adjacent regions are, and what becomes of them.
///
/// `Evidence` is what a metric keeps of an edge; where two edges become one, theirs is added up.
/// `dissimilarity` decides the order of the merges, and must give the same bits for (a, b) and (b, a);
/// `weight` maps it to [0, 1], where it may saturate; it grows with it, up to rounding. `too_small` tells regions that
/// cannot stay on their own; merging never makes a region too small.
template <typename T>
concept Metric = requires(T metric, const T& constant, typename T::Evidence evidence, std::uint32_t r, double d) {
  { constant.region_count() } -> std::convertible_to<std::size_t>;
  { constant.points(r) } -> std::convertible_to<std::uint32_t>;
  { constant.dissimilarity(r, r, evidence) } -> std::convertible_to<double>;
  { constant.weight(d) } -> std::convertible_to<double>;
  { constant.too_small(r) } -> std::convertible_to<bool>;
  metric.merge(r, r);
  evidence += evidence;
};

/// A metric that looks at no evidence may compute many dissimilarities at once, and know those of the initial edges.
template <typename T>
concept BatchMetric = Metric<T> && requires(const T& constant, std::span<const RegionEdge> pairs, double* result) {
  constant.dissimilarities(pairs, result);
  { constant.initial_dissimilarities() } -> std::same_as<std::span<const double>>;
};

/// The merging process of section 2.1: while edges are left, the two regions of the smallest weight
/// become one, and its edges get new weights (eq. 2). Every region keeps its edges in a list by
/// neighbour, and the best of those to larger regions takes part in a tournament.
///
/// When no weight below the threshold is left, regions that are too small join the neighbour they are least unlike
/// before all others, with a weight just below the threshold: a cut there, or higher, has none of them left but
/// those without any neighbour.
template <Metric M>
class Merger {
 public:
  using Evidence = typename M::Evidence;
  class Scratch;

  /// `edges`: those of the graph that the metric looks at; `evidence` has one entry an edge.
  Merger(std::span<const RegionEdge> edges, std::span<const Evidence> evidence, double threshold, M& metric,
         const StopToken& stop, Scratch& scratch)
      : metric_(metric),
        threshold_(threshold),
        below_([&metric](double dissimilarity) { return metric.weight(dissimilarity); }, threshold),
        stop_(stop),
        check_(stop),
        regions_(static_cast<std::uint32_t>(metric.region_count())),
        links_(scratch.links_),
        best_(metric.region_count(), Edge{}) {
    reserve_links(edges);
    const std::span<const double> initial = measure_all(edges, evidence);
    check_.for_each(0, edges.size(), [&](std::size_t e) {
      const auto [a, b] = edges[e];
      links_[a].push_back(link(b, initial[e], evidence[e]));
      links_[b].push_back(links_[a].back().back_to(a));
    });
    for (std::uint32_t r = 0; r < regions_ && !check_.after(1 + links_[r].size()); ++r) {
      if (!std::ranges::is_sorted(links_[r], {}, &Link::region)) std::ranges::sort(links_[r], {}, &Link::region);
      find_best(r);
    }
  }

  absl::StatusOr<MergeTree> run() {
    if (absl::Status status = stop_.check(); !status.ok()) return status;
    std::vector<std::uint32_t> points(regions_);
    check_.for_each(0, points.size(),
                    [&](std::size_t r) { points[r] = metric_.points(static_cast<std::uint32_t>(r)); });
    TreeBuilder tree(std::move(points));
    while (best_.winner().turn() != Turn::kNever && !check_.after(1)) {
      const Edge edge = best_.winner();
      tree.merge(edge.a(), edge.b(), weight(edge));
      unite(edge.a(), edge.b());
    }
    tree.join_components(check_);
    if (absl::Status status = stop_.check(); !status.ok()) return status;
    return std::move(tree).finish();
  }

 private:
  using Turn = MergeTurn;
  using Edge = MergeCandidate;

  static constexpr std::size_t kSpareLinks = 4;

  struct Link {
    std::uint32_t region;
    bool below;  // its weight is below the threshold
    double dissimilarity;
    [[no_unique_address]] Evidence evidence;

    Link back_to(std::uint32_t r) const { return {r, below, dissimilarity, evidence}; }
  };

  Link link(std::uint32_t to, double dissimilarity, const Evidence& evidence) const {
    const auto weight = [this](double d) { return metric_.weight(d); };
    return {to, below_(weight, dissimilarity), dissimilarity, evidence};
  }

  std::span<const double> measure_all(std::span<const RegionEdge> edges, std::span<const Evidence> evidence) {
    if constexpr (BatchMetric<M>) {
      return metric_.initial_dissimilarities();
    } else {
      measured_.resize(edges.size());
      check_.for_each(0, edges.size(), [&](std::size_t e) {
        measured_[e] = metric_.dissimilarity(edges[e].a, edges[e].b, evidence[e]);
      });
      return measured_;
    }
  }

  /// All edges of region p anew.
  void measure_links(std::uint32_t p) {
    std::vector<Link>& links = links_[p];
    if constexpr (BatchMetric<M>) {
      pairs_.clear();
      for (const Link& to : links) pairs_.push_back({p, to.region});
      measured_.resize(links.size());
      metric_.dissimilarities(pairs_, measured_.data());
      for (std::size_t i = 0; i < links.size(); ++i) links[i] = link(links[i].region, measured_[i], links[i].evidence);
    } else {
      for (Link& to : links) to = link(to.region, metric_.dissimilarity(p, to.region, to.evidence), to.evidence);
    }
  }

  Edge edge(std::uint32_t a, const Link& link) const {
    Turn turn = Turn::kLast;
    if (link.below) {
      turn = Turn::kFirst;
    } else if (metric_.too_small(a) || metric_.too_small(link.region)) {
      turn = Turn::kTooSmall;
    }
    return {turn, link.dissimilarity, a, link.region};
  }

  /// One allocation a region at most, instead of one for each doubling.
  void reserve_links(std::span<const RegionEdge> edges) {
    if (links_.size() < regions_) links_.resize(regions_);
    std::vector<std::uint32_t> count(regions_, 0);
    check_.for_each(0, edges.size(), [&](std::size_t e) { ++count[edges[e].a], ++count[edges[e].b]; });
    check_.for_each(0, count.size(), [&](std::size_t r) {
      links_[r].clear();
      links_[r].reserve(count[r] + kSpareLinks);
    });
  }

  double weight(const Edge& e) const {
    const double weight = metric_.weight(e.dissimilarity());
    constexpr double kJustBelow = 1 - 1e-12;
    return e.turn() == Turn::kTooSmall ? std::min(weight, kJustBelow * threshold_) : weight;
  }

  /// r_p takes over r_q (p < q), its points and its edges.
  void unite(std::uint32_t p, std::uint32_t q) {
    metric_.merge(p, q);
    unite_links(p, q);
    links_[q].clear();
    best_.set(q, Edge{});
    check_.after(2 * links_[p].size());
    measure_links(p);
    for (std::size_t i = 0; i < links_[p].size(); ++i) replace_links(links_[p][i], p, q, had_q_[i] != 0);
    find_best(p);
  }

  /// All neighbours of either region but themselves, ascending. `had_q_`: which of them q had a link to.
  void unite_links(std::uint32_t p, std::uint32_t q) {
    united_.clear();
    had_q_.clear();
    const std::vector<Link>&of_p = links_[p], &of_q = links_[q];
    for (auto i = of_p.begin(), j = of_q.begin(); i != of_p.end() || j != of_q.end();) {
      const bool from_p = i != of_p.end() && (j == of_q.end() || i->region <= j->region);
      const bool from_q = j != of_q.end() && (i == of_p.end() || j->region <= i->region);
      const Link& link = from_p ? *i : *j;
      if (link.region != p && link.region != q) {
        united_.push_back(link);
        if (from_p && from_q) united_.back().evidence += j->evidence;
        had_q_.push_back(from_q);
      }
      i += static_cast<std::ptrdiff_t>(from_p);
      j += static_cast<std::ptrdiff_t>(from_q);
    }
    links_[p].swap(united_);
  }

  /// In the list of the neighbour that `link` of region p leads to, one link back to p in place of
  /// those to p and q.
  void replace_links(const Link& link, std::uint32_t p, std::uint32_t q, bool had_q) {
    const std::uint32_t n = link.region;
    std::vector<Link>& links = links_[n];
    const Link back = link.back_to(p);
    Link* const at = not_before(links, p);
    if (had_q) {
      Link* const old = not_before(links, q);
      if (at->region == p) {
        links.erase(links.begin() + (old - links.data()));
      } else {  // what stands between makes room
        std::move_backward(at, old, old + 1);
      }
    }
    *at = back;
    const Edge& best = best_[n];
    const Edge candidate = n < p ? edge(n, back) : Edge{};
    if (candidate < best) {
      best_.set(n, candidate);
    } else if (best.turn() != Turn::kNever && (best.b() == p || best.b() == q) && candidate != best) {
      find_best(n);
    }
  }

  /// The first link to `region` or a larger one; to the last if there is none. Without branches.
  static Link* not_before(std::vector<Link>& links, std::uint32_t region) {
    Link* first = links.data();
    for (std::size_t left = links.size(); left > 1;) {
      const std::size_t half = left / 2;
      first += static_cast<std::size_t>(first[half - 1].region < region) * half;
      left -= half;
    }
    return first;
  }

  /// Every edge takes part once: for the smaller of its regions.
  void find_best(std::uint32_t r) {
    Edge best;
    const std::vector<Link>& links = links_[r];
    check_.after(links.size());
    for (auto link = links.rbegin(); link != links.rend() && link->region > r; ++link) {
      if (!link->below && best.turn() == Turn::kFirst) continue;
      const Edge candidate = edge(r, *link);
      best = std::min(candidate, best);
    }
    best_.set(r, best);
  }

  M& metric_;
  double threshold_;
  BelowThreshold below_;
  const StopToken& stop_;
  StopCheck check_;
  const std::uint32_t regions_;
  std::vector<std::vector<Link>>& links_;  // of each region; there may be more
  std::vector<Link> united_;
  std::vector<std::uint8_t> had_q_;
  std::vector<RegionEdge> pairs_;
  std::vector<double> measured_;
  Tournament<Edge> best_;
};

/// Buffers of `merge_regions` that are worth keeping between calls.
template <Metric M>
class Merger<M>::Scratch {
  friend class Merger;
  std::vector<std::vector<Link>> links_;
};

/// The merge tree of a graph under a metric, which is used up. `evidence`: one entry an edge; `threshold`, [0, 1]: from
/// there on no region that is too small is left. CANCELLED, DEADLINE_EXCEEDED.
template <Metric M>
absl::StatusOr<MergeTree> merge_regions(std::span<const RegionEdge> edges,
                                        std::span<const typename M::Evidence> evidence, double threshold, M& metric,
                                        const StopToken& stop, typename Merger<M>::Scratch& scratch) {
  return Merger<M>(edges, evidence, threshold, metric, stop, scratch).run();
}

/// The same for a single graph.
template <Metric M>
absl::StatusOr<MergeTree> merge_regions(std::span<const RegionEdge> edges,
                                        std::span<const typename M::Evidence> evidence, double threshold, M& metric,
                                        const StopToken& stop = {}) {
  typename Merger<M>::Scratch scratch;
  return merge_regions<M>(edges, evidence, threshold, metric, stop, scratch);
}

}  // namespace segserve
