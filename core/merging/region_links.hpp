// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/stop_check.hpp"
#include "core/region_graph/region_edge.hpp"

namespace segserve {

/// One direction of an edge between two regions, as the list of one of them holds it.
template <typename Evidence>
struct RegionLink {
  std::uint32_t region;  ///< the neighbor that it leads to
  bool below_threshold;  ///< whether the weight of the edge is below the threshold
  double dissimilarity;
  [[no_unique_address]] Evidence evidence;

  /// The other direction of the edge, where this one is in the list of region r.
  RegionLink back_to(std::uint32_t r) const { return {r, below_threshold, dissimilarity, evidence}; }
};

/// The links of every region, ascending by neighbor, while regions merge.
template <typename Evidence>
class RegionLinks {
 public:
  using Link = RegionLink<Evidence>;

  /// Empties the lists of all regions and gives each enough memory for its edges.
  void reset(std::uint32_t regions, std::span<const RegionEdge> edges, StopCheck& check) {
    constexpr std::size_t kSpare = 4;
    if (links_.size() < regions) links_.resize(regions);
    std::vector<std::uint32_t> count(regions, 0);
    check.for_each(0, edges.size(), [&](std::size_t e) { ++count[edges[e].a], ++count[edges[e].b]; });
    check.for_each(0, count.size(), [&](std::size_t r) {
      links_[r].clear();
      links_[r].reserve(count[r] + kSpare);
    });
  }

  std::vector<Link>& of(std::uint32_t region) { return links_[region]; }
  const std::vector<Link>& of(std::uint32_t region) const { return links_[region]; }

  /// The link of region a to b, which must be there.
  const Link& find(std::uint32_t a, std::uint32_t b) { return *lower_bound(links_[a], b); }

  /// Adds an edge of regions a and b to both lists. They may be out of order until `sort`.
  void add(std::uint32_t a, const Link& link) {
    links_[a].push_back(link);
    links_[link.region].push_back(link.back_to(a));
  }
  void sort(std::uint32_t region) {
    if (!std::ranges::is_sorted(links_[region], {}, &Link::region))
      std::ranges::sort(links_[region], {}, &Link::region);
  }

  /// Region p takes over the links of region q, p < q; evidence of both to the same neighbor is added up. The lists of
  /// the neighbors stay as they are, for `relink`.
  void merge(std::uint32_t p, std::uint32_t q) {
    merged_.clear();
    linked_to_q_.clear();
    const std::vector<Link>&of_p = links_[p], &of_q = links_[q];
    for (auto i = of_p.begin(), j = of_q.begin(); i != of_p.end() || j != of_q.end();) {
      const bool from_p = i != of_p.end() && (j == of_q.end() || i->region <= j->region);
      const bool from_q = j != of_q.end() && (i == of_p.end() || j->region <= i->region);
      const Link& link = from_p ? *i : *j;
      if (link.region != p && link.region != q) {
        merged_.push_back(link);
        if (from_p && from_q) merged_.back().evidence += j->evidence;
        linked_to_q_.push_back(from_q);
      }
      i += static_cast<std::ptrdiff_t>(from_p);
      j += static_cast<std::ptrdiff_t>(from_q);
    }
    links_[p].swap(merged_);
    links_[q].clear();
  }

  /// After merge(p, q): whether the i-th neighbor of p was one of q.
  bool was_linked_to_q(std::size_t i) const { return linked_to_q_[i] != 0; }

  /// After merge(p, q): makes `back`, which leads to p, replace the links to p and q in the list of the i-th neighbor
  /// of p.
  void relink(std::size_t i, const Link& back, std::uint32_t neighbor, std::uint32_t q) {
    std::vector<Link>& links = links_[neighbor];
    Link* const at = lower_bound(links, back.region);
    if (was_linked_to_q(i)) {
      Link* const old = lower_bound(links, q);
      if (at->region == back.region) {
        links.erase(links.begin() + (old - links.data()));
      } else {  // The links between the two places make room.
        std::move_backward(at, old, old + 1);
      }
    }
    *at = back;
  }

 private:
  /// The first link to `region` or a larger one, or the last link if there is none. It has no branches, which would
  /// often be mispredicted.
  static Link* lower_bound(std::vector<Link>& links, std::uint32_t region) {
    Link* first = links.data();
    for (std::size_t left = links.size(); left > 1;) {
      const std::size_t half = left / 2;
      first += static_cast<std::size_t>(first[half - 1].region < region) * half;
      left -= half;
    }
    return first;
  }

  std::vector<std::vector<Link>> links_;  // of each region; there may be more lists than regions
  std::vector<Link> merged_;
  std::vector<std::uint8_t> linked_to_q_;  // for each link of p: whether q had one to the same neighbor
};

}  // namespace segserve
