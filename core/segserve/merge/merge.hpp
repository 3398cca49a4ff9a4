#pragma once

#include <algorithm>
#include <concepts>
#include <cstdint>
#include <limits>
#include <span>
#include <tuple>
#include <vector>

#include "absl/status/statusor.h"
#include "segserve/graph/region_graph.hpp"
#include "segserve/merge/tournament.hpp"
#include "segserve/merge/tree_builder.hpp"
#include "segserve/pipeline/stop_token.hpp"
#include "segserve/tree/merge_tree.hpp"

namespace segserve {

/// What the paper calls modular: how unlike two adjacent regions are, and what becomes of them.
template <typename T>
concept Metric = requires(T metric, const T& constant, std::uint32_t r) {
  { constant.region_count() } -> std::convertible_to<std::size_t>;
  { constant.points(r) } -> std::convertible_to<std::uint32_t>;
  { constant.dissimilarity(r, r) } -> std::convertible_to<double>;
  metric.merge(r, r);
};

/// The merging process of section 2.1: while edges are left, the two regions of the smallest weight
/// become one, and its edges get new weights (eq. 2). Every region keeps its edges in a list by
/// neighbour, and the best of those to larger regions takes part in a tournament.
template <Metric M>
class Merger {
 public:
  Merger(std::span<const RegionEdge> edges, M& metric)
      : metric_(metric), links_(metric.region_count()), best_(metric.region_count(), Edge{}) {
    for (const auto& [a, b] : edges) {
      const double weight = metric_.dissimilarity(a, b);
      links_[a].push_back({b, weight});
      links_[b].push_back({a, weight});
    }
    for (std::vector<Link>& links : links_) std::ranges::sort(links, {}, &Link::region);
    for (std::uint32_t r = 0; r < links_.size(); ++r) find_best(r);
  }

  absl::StatusOr<MergeTree> run(const StopToken& stop) {
    constexpr std::size_t kStopInterval = 64;
    std::vector<std::uint32_t> points(links_.size());
    for (std::uint32_t r = 0; r < points.size(); ++r) points[r] = metric_.points(r);
    TreeBuilder tree(std::move(points));
    for (std::size_t row = 0; best_.winner().weight < kNone; ++row) {
      if (row % kStopInterval == 0) {
        if (absl::Status status = stop.check(); !status.ok()) return status;
      }
      const Edge edge = best_.winner();
      tree.merge(edge.a, edge.b, edge.weight);
      unite(edge.a, edge.b);
    }
    tree.join_components();
    return std::move(tree).finish();
  }

 private:
  static constexpr double kNone = std::numeric_limits<double>::infinity();

  struct Link {
    std::uint32_t region;
    double weight;
  };

  /// Equal weights: the smaller ids first.
  struct Edge {
    double weight = kNone;
    std::uint32_t a = 0, b = 0;
    bool operator<(const Edge& o) const { return std::tie(weight, a, b) < std::tie(o.weight, o.a, o.b); }
  };

  /// r_p takes over r_q (p < q), its points and its edges.
  void unite(std::uint32_t p, std::uint32_t q) {
    metric_.merge(p, q);
    unite_links(p, q);
    links_[q] = {};
    best_.set(q, Edge{});
    for (Link& link : links_[p]) {
      link.weight = metric_.dissimilarity(p, link.region);
      replace_links(link.region, p, q, link.weight);
    }
    find_best(p);
  }

  /// All neighbours of either region but themselves, ascending.
  void unite_links(std::uint32_t p, std::uint32_t q) {
    united_.clear();
    std::ranges::merge(links_[p], links_[q], std::back_inserter(united_), {}, &Link::region, &Link::region);
    const auto [last, end] = std::ranges::unique(united_, {}, &Link::region);
    united_.erase(last, end);
    std::erase_if(united_, [&](const Link& link) { return link.region == p || link.region == q; });
    links_[p].assign(united_.begin(), united_.end());
  }

  /// In the list of a neighbour n, one link to p in place of those to p and q.
  void replace_links(std::uint32_t n, std::uint32_t p, std::uint32_t q, double weight) {
    std::vector<Link>& links = links_[n];
    const auto at = [&](std::uint32_t region) { return std::ranges::lower_bound(links, region, {}, &Link::region); };
    if (const auto link = at(q); link != links.end() && link->region == q) links.erase(link);
    const auto link = at(p);
    if (link != links.end() && link->region == p) {
      link->weight = weight;
    } else {
      links.insert(link, {p, weight});
    }
    const Edge& best = best_[n];
    if (best.weight < kNone && (best.b == p || best.b == q)) {
      find_best(n);
    } else if (const Edge edge{weight, n, p}; n < p && edge < best) {
      best_.set(n, edge);
    }
  }

  /// Every edge takes part once: for the smaller of its regions.
  void find_best(std::uint32_t r) {
    Edge best;
    const std::vector<Link>& links = links_[r];
    for (auto link = std::ranges::upper_bound(links, r, {}, &Link::region); link != links.end(); ++link) {
      best = std::min(best, Edge{link->weight, r, link->region});
    }
    best_.set(r, best);
  }

  M& metric_;
  std::vector<std::vector<Link>> links_;
  std::vector<Link> united_;
  Tournament<Edge> best_;
};

/// The merge tree of a graph under a metric, which is used up. CANCELLED, DEADLINE_EXCEEDED.
template <Metric M>
absl::StatusOr<MergeTree> merge_regions(std::span<const RegionEdge> edges, M& metric, const StopToken& stop = {}) {
  return Merger<M>(edges, metric).run(stop);
}

}  // namespace segserve
