// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "core/base/frame_context.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
#include "core/merging/merge_candidate.hpp"
#include "core/merging/merge_tree_builder.hpp"
#include "core/merging/region_links.hpp"
#include "core/merging/tournament_tree.hpp"
#include "core/region_graph/region_edge.hpp"
#include "core/weights/region_metric.hpp"
#include "segserve/merge_tree.hpp"

namespace segserve {

/// The merging of one graph; see Merger.
template <RegionMetric Metric>
class MergeProcess {
 public:
  using Evidence = typename Metric::Evidence;
  using Links = RegionLinks<Evidence>;

  MergeProcess(std::span<const RegionEdge> edges, double threshold, Metric& metric, StopCheck& check, Links& links)
      : metric_(metric),
        threshold_(threshold),
        check_(check),
        regions_(static_cast<std::uint32_t>(metric.region_count())),
        links_(links),
        best_(regions_, MergeCandidate{}) {
    links_.reset(regions_, edges, check_);
    const std::span<const double> initial = measure_all(edges);
    check_.for_each(0, edges.size(), [&](std::size_t e) {
      links_.add(edges[e].a, make_link(edges[e].b, initial[e], metric_.evidence(e)));
    });
    for (std::uint32_t r = 0; r < regions_ && !check_.after(1 + links_.of(r).size()); ++r) {
      links_.sort(r);
      find_best(r);
    }
  }

  /// Merges regions until no edge is left, and joins the components.
  MergeTree run() {
    std::vector<std::uint32_t> points(regions_);
    check_.for_each(0, regions_, [&](std::size_t r) { points[r] = metric_.points(static_cast<std::uint32_t>(r)); });
    MergeTreeBuilder tree(std::move(points));
    while (best_.winner().is_edge() && !check_.after(1)) {
      const MergeCandidate edge = best_.winner();
      tree.merge(edge.a(), edge.b(), weight(edge));
      merge(edge.a(), edge.b());
    }
    tree.join_components(check_);
    return std::move(tree).finish();
  }

 private:
  using Link = typename Links::Link;

  Link make_link(std::uint32_t to, double dissimilarity, const Evidence& evidence) const {
    return {to, metric_.weight(dissimilarity) < threshold_, dissimilarity, evidence};
  }

  /// The dissimilarities of all edges before any merge.
  std::span<const double> measure_all(std::span<const RegionEdge> edges) {
    if constexpr (BatchRegionMetric<Metric>) {
      return metric_.initial_dissimilarities();
    } else {
      measured_.resize(edges.size());
      check_.for_each(0, edges.size(), [&](std::size_t e) {
        measured_[e] = metric_.dissimilarity(edges[e].a, edges[e].b, metric_.evidence(e));
      });
      return measured_;
    }
  }

  /// Finds which links of region p change when it takes over the regions and links of region q.
  void find_changes(std::uint32_t p, std::uint32_t q) {
    const std::vector<Link>& links = links_.of(p);
    const bool changes_all = metric_.too_small(p) || metric_.changes_all(p, q);
    changed_.resize(links.size());
    for (std::size_t i = 0; i < links.size(); ++i) {
      changed_[i] =
          static_cast<std::uint8_t>(changes_all || links_.was_linked_to_q(i) || metric_.counts(p, links[i].region));
    }
  }

  bool is_changed(std::size_t i) const {
    if constexpr (PartialRegionMetric<Metric>) {
      return changed_[i] != 0;
    } else {
      return true;
    }
  }

  /// Updates the links of region p after it has changed.
  void measure_links(std::uint32_t p) {
    std::vector<Link>& links = links_.of(p);
    if constexpr (BatchRegionMetric<Metric>) {
      pairs_.clear();
      for (const Link& to : links) pairs_.push_back({p, to.region});
      measured_.resize(links.size());
      metric_.dissimilarities(pairs_, measured_.data());
      for (std::size_t i = 0; i < links.size(); ++i) {
        links[i] = make_link(links[i].region, measured_[i], links[i].evidence);
      }
    } else {
      for (std::size_t i = 0; i < links.size(); ++i) {
        if (!is_changed(i)) continue;
        Link& to = links[i];
        to = make_link(to.region, metric_.dissimilarity(p, to.region, to.evidence), to.evidence);
      }
    }
  }

  MergeCandidate candidate(std::uint32_t a, const Link& link) const {
    MergePriority priority = MergePriority::kOther;
    if (link.below_threshold) {
      priority = MergePriority::kBelowThreshold;
    } else if (metric_.too_small(a) || metric_.too_small(link.region)) {
      priority = MergePriority::kTooSmall;
    }
    return {priority, link.dissimilarity, a, link.region};
  }

  double weight(const MergeCandidate& edge) const {
    const double weight = metric_.weight(edge.dissimilarity());
    constexpr double kJustBelow = 1 - 1e-12;
    return edge.priority() == MergePriority::kTooSmall ? std::min(weight, kJustBelow * threshold_) : weight;
  }

  /// Region q joins region p, p < q.
  void merge(std::uint32_t p, std::uint32_t q) {
    const Evidence between = links_.find(p, q).evidence;
    links_.merge(p, q);
    if constexpr (PartialRegionMetric<Metric>) find_changes(p, q);
    metric_.merge(p, q, between);
    best_.set(q, MergeCandidate{});
    const std::vector<Link>& links = links_.of(p);
    check_.after(2 * links.size());
    measure_links(p);
    for (std::size_t i = 0; i < links.size(); ++i) {
      if (!is_changed(i)) continue;
      const Link back = links[i].back_to(p);
      links_.relink(i, back, links[i].region, q);
      update_best(links[i].region, back, q);
    }
    find_best(p);
  }

  /// Updates the best edge of region n, whose link `back` replaced those to its region and to q.
  void update_best(std::uint32_t n, const Link& back, std::uint32_t q) {
    const std::uint32_t p = back.region;
    const MergeCandidate& best = best_[n];
    const MergeCandidate changed = n < p ? candidate(n, back) : MergeCandidate{};
    if (changed < best) {
      best_.set(n, changed);
    } else if (best.is_edge() && (best.b() == p || best.b() == q) && changed != best) {
      find_best(n);
    }
  }

  /// Finds the best edge of region r to larger regions. So every edge takes part once.
  void find_best(std::uint32_t r) {
    MergeCandidate best;
    const std::vector<Link>& links = links_.of(r);
    check_.after(links.size());
    for (auto link = links.rbegin(); link != links.rend() && link->region > r; ++link) {
      if (!link->below_threshold && best.priority() == MergePriority::kBelowThreshold) continue;
      best = std::min(candidate(r, *link), best);
    }
    best_.set(r, best);
  }

  Metric& metric_;
  double threshold_;
  StopCheck& check_;
  const std::uint32_t regions_;
  Links& links_;
  TournamentTree<MergeCandidate> best_;  // of each region's edges to larger regions
  std::vector<RegionEdge> pairs_;
  std::vector<double> measured_;
  std::vector<std::uint8_t> changed_;  // for each link of the region that grows
};

/// The merging process of section 2.1 of the paper: while edges are left, the two regions of the smallest weight become
/// one, and its edges get new weights (eq. 2). Every region keeps its edges in a list, and the best of those to larger
/// regions takes part in a tournament.
///
/// When no weight below the threshold is left, regions that are too small join the neighbor that they are least
/// dissimilar to, with a weight just below the threshold, before all others merge. So a cut at the threshold, or
/// higher, has no such regions left but those without any neighbor.
template <RegionMetric Metric>
class Merger {
 public:
  /// Sets `tree` to the merge tree of the graph with these edges. The metric is used up. The threshold, in [0, 1], is
  /// the one from which on no region is too small. A merge takes a time in proportion to the links of the two regions,
  /// and looks only at those that change. CANCELLED, DEADLINE_EXCEEDED.
  absl::Status run(const FrameContext& frame, std::span<const RegionEdge> edges, double threshold, Metric& metric,
                   MergeTree& tree) {
    StopCheck check(frame.stop);
    tree = MergeProcess<Metric>(edges, threshold, metric, check, links_).run();
    return check.status();
  }

 private:
  RegionLinks<typename Metric::Evidence> links_;
};

}  // namespace segserve
