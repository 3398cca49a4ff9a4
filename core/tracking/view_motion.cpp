// SPDX-License-Identifier: Apache-2.0
#include "core/tracking/view_motion.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace segserve::tracking {
namespace {

constexpr double kSameColor = 50;        // distance in RGB
constexpr double kSameSize = 2.5;        // ratio of areas
constexpr std::size_t kGuides = 10;      // of the landmarks before, the largest, from which motions are guessed
constexpr std::size_t kMostPairs = 256;  // of landmarks that look alike
constexpr double kSmallestCosine = 0.7;  // of the turn between two frames
constexpr double kPreference = 1.1;      // of the identity, so that noise moves nothing
constexpr int kFits = 2;

/// A turn about the vertical and a shift: (u, v) -> (c u - s v + x, s u + c v + y).
struct Turn {
  double c = 1, s = 0, x = 0, y = 0;
};

/// Landmarks that look alike.
struct Pair {
  std::size_t before, now;
};

class LandmarkMatching {
 public:
  LandmarkMatching(std::span<const Landmark> before, std::span<const Landmark> now, double tolerance)
      : before_(before), now_(now), tolerance_(tolerance) {
    for (std::size_t i = 0; i < before.size(); ++i) {
      for (std::size_t j = 0; j < now.size() && pairs_.size() < kMostPairs; ++j) {
        if (look_alike(before[i], now[j])) pairs_.push_back({i, j});
      }
    }
  }

  Turn best() {
    best_score_ = kPreference * score({});
    const auto guides = std::ranges::find_if(pairs_, [](const Pair& p) { return p.before >= kGuides; });
    for (auto a = pairs_.begin(); a != guides; ++a) {
      try_turn(shift(*a));
      for (auto b = a + 1; b != guides; ++b) try_pairs(*a, *b);
    }
    for (int i = 0; i < kFits; ++i) best_ = fit(best_);
    return best_;
  }

 private:
  bool look_alike(const Landmark& a, const Landmark& b) const {
    return std::max(a.area, b.area) <= kSameSize * std::min(a.area, b.area) &&
           std::fabs(a.place.z - b.place.z) <= 2 * tolerance_ && norm(a.color - b.color) <= kSameColor;
  }

  Turn shift(const Pair& p) const {
    const Vec3 d = now_[p.now].place - before_[p.before].place;
    return {1, 0, d.x, d.y};
  }

  void try_pairs(const Pair& a, const Pair& b) {
    if (a.before == b.before || a.now == b.now) return;
    const Vec3 p = before_[b.before].place - before_[a.before].place, q = now_[b.now].place - now_[a.now].place;
    const double length_p = std::sqrt(p.x * p.x + p.y * p.y), length_q = std::sqrt(q.x * q.x + q.y * q.y);
    if (std::min(length_p, length_q) < 3 * tolerance_ || std::fabs(length_p - length_q) > 2 * tolerance_) return;
    const double product = length_p * length_q;
    const double c = (p.x * q.x + p.y * q.y) / product, s = (p.x * q.y - p.y * q.x) / product;
    if (c < kSmallestCosine) return;
    const Vec3 from = 0.5 * (before_[a.before].place + before_[b.before].place);
    const Vec3 to = 0.5 * (now_[a.now].place + now_[b.now].place);
    try_turn({c, s, to.x - (c * from.x - s * from.y), to.y - (s * from.x + c * from.y)});
  }

  void try_turn(const Turn& turn) {
    const double value = score(turn);
    if (value > best_score_) best_score_ = value, best_ = turn;
  }

  double squared_distance(const Turn& t, const Pair& p) const {
    const Vec3& a = before_[p.before].place;
    const Vec3& b = now_[p.now].place;
    const double x = t.c * a.x - t.s * a.y + t.x - b.x, y = t.s * a.x + t.c * a.y + t.y - b.y;
    return x * x + y * y;
  }

  /// Each landmark counts by its size, and by how close the closest that looks alike is.
  double score(const Turn& turn) const {
    double sum = 0;
    for (std::size_t k = 0; k < pairs_.size();) {
      const std::size_t i = pairs_[k].before;
      double closest = 1e30;
      for (; k < pairs_.size() && pairs_[k].before == i; ++k)
        closest = std::min(closest, squared_distance(turn, pairs_[k]));
      sum += std::sqrt(before_[i].area) / (1 + closest / (tolerance_ * tolerance_));
    }
    return sum;
  }

  /// Least squares over the pairs that agree.
  Turn fit(const Turn& turn) const {
    std::vector<Pair> agreeing;
    for (std::size_t k = 0; k < pairs_.size();) {
      const std::size_t i = pairs_[k].before;
      Pair closest = pairs_[k];
      for (; k < pairs_.size() && pairs_[k].before == i; ++k) {
        if (squared_distance(turn, pairs_[k]) < squared_distance(turn, closest)) closest = pairs_[k];
      }
      if (squared_distance(turn, closest) <= tolerance_ * tolerance_) agreeing.push_back(closest);
    }
    if (agreeing.empty()) return turn;
    Vec3 from, to;
    for (const Pair& p : agreeing) from += before_[p.before].place, to += now_[p.now].place;
    const double share = 1.0 / static_cast<double>(agreeing.size());
    from = share * from, to = share * to;
    Turn fitted = turn;
    double cosine = 0, sine = 0;
    for (const Pair& p : agreeing) {
      const Vec3 a = before_[p.before].place - from, b = now_[p.now].place - to;
      cosine += a.x * b.x + a.y * b.y, sine += a.x * b.y - a.y * b.x;
    }
    const double length = std::sqrt(cosine * cosine + sine * sine);
    if (agreeing.size() >= 3 && length > 0) fitted.c = cosine / length, fitted.s = sine / length;
    fitted.x = to.x - (fitted.c * from.x - fitted.s * from.y);
    fitted.y = to.y - (fitted.s * from.x + fitted.c * from.y);
    return fitted;
  }

  std::span<const Landmark> before_, now_;
  double tolerance_;
  std::vector<Pair> pairs_;  // by ascending landmark of the frame before
  Turn best_;
  double best_score_ = 0;
};

}  // namespace

RigidMotion match_landmarks(std::span<const Landmark> before, std::span<const Landmark> now, double tolerance) {
  if (before.empty() || now.empty()) return {};
  const Turn t = LandmarkMatching(before, now, tolerance).best();
  return {{t.c, t.s, 0}, {-t.s, t.c, 0}, {0, 0, 1}, {t.x, t.y, 0}};
}

}  // namespace segserve::tracking
