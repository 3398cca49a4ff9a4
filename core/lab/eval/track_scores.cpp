// SPDX-License-Identifier: Apache-2.0
#include "core/lab/eval/track_scores.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "core/lab/eval/assignment.hpp"
#include "core/lab/eval/scores.hpp"

namespace segserve::eval {
namespace {

constexpr std::size_t kLevels = 19;  // 0.05, 0.1 and so on
constexpr std::size_t kHalf = 9;     // the level of 0.5
constexpr double kStep = 0.05;
constexpr double kRounding = 1e-9;
constexpr double kLeastSimilarity = 0.5;
constexpr double kPersistence = 1000;  // a pair of the frame before is preferred to any similarity

/// A sparse matrix of objects and tracks.
using PairCounts = std::map<std::pair<std::size_t, std::size_t>, double>;

double at(const PairCounts& counts, std::size_t object, std::size_t track) {
  const auto found = counts.find({object, track});
  return found == counts.end() ? 0 : found->second;
}

/// The assignment with the largest sum of weights, as the column of each row; pairs without weight are left out.
std::vector<std::pair<std::size_t, std::size_t>> best_pairs(std::span<const double> weights, std::size_t rows,
                                                            std::size_t columns) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  if (rows == 0 || columns == 0) return pairs;
  const std::size_t width = std::max(rows, columns);
  std::vector<double> padded(rows * width, 0);
  for (std::size_t r = 0; r < rows; ++r) {
    std::copy_n(weights.begin() + static_cast<std::ptrdiff_t>(r * columns), columns,
                padded.begin() + static_cast<std::ptrdiff_t>(r * width));
  }
  const std::vector<std::size_t> column_of = best_assignment(padded, rows, width);
  for (std::size_t r = 0; r < rows; ++r) {
    if (column_of[r] < columns && weights[r * columns + column_of[r]] > 0) pairs.emplace_back(r, column_of[r]);
  }
  return pairs;
}

std::size_t position_of(const std::vector<std::size_t>& list, std::size_t value) {
  return static_cast<std::size_t>(std::ranges::find(list, value) - list.begin());
}

}  // namespace

std::size_t TrackScoring::number_of(std::uint32_t label, std::map<std::uint32_t, std::size_t>& numbers) {
  return numbers.try_emplace(label, numbers.size()).first->second;
}

void TrackScoring::add(const Contingency& table) {
  // Points of regions that are too small count for nothing.
  std::vector<bool> is_region(table.regions.size()), is_object(table.regions.size());
  for (std::size_t r = 0; r < table.regions.size(); ++r) {
    is_region[r] = table.regions[r].points >= least_points_;
    is_object[r] = is_region[r] && table.regions[r].label >= kFirstObjectLabel;
  }
  std::vector<std::uint64_t> points(table.segments.size(), 0), on_objects(table.segments.size(), 0);
  for (const Overlap& overlap : table.overlaps) {
    if (is_region[overlap.region]) points[overlap.segment] += overlap.points;
    if (is_object[overlap.region]) on_objects[overlap.segment] += overlap.points;
  }
  Frame frame;
  std::vector<std::size_t> object_of(table.regions.size()), track_of(table.segments.size());
  std::vector<bool> is_track(table.segments.size(), false);
  for (std::size_t r = 0; r < table.regions.size(); ++r) {
    if (is_object[r]) frame.objects.push_back(object_of[r] = number_of(table.regions[r].label, object_numbers_));
  }
  for (std::size_t s = 0; s < table.segments.size(); ++s) {
    is_track[s] = table.segments[s].label != 0 && points[s] >= least_points_ && 2 * on_objects[s] > points[s];
    if (is_track[s]) frame.tracks.push_back(track_of[s] = number_of(table.segments[s].label, track_numbers_));
  }
  for (const Overlap& overlap : table.overlaps) {
    if (!is_object[overlap.region] || !is_track[overlap.segment]) continue;
    const std::uint64_t united = table.regions[overlap.region].points + points[overlap.segment] - overlap.points;
    frame.pairs.push_back({object_of[overlap.region], track_of[overlap.segment],
                           static_cast<double>(overlap.points) / static_cast<double>(united)});
  }
  frames_.push_back(std::move(frame));
}

void TrackScoring::score_hota(TrackScores& scores) const {
  // How well each track fits each object over the whole sequence decides between pairs of a frame.
  PairCounts potential;
  std::vector<double> object_frames(object_numbers_.size(), 0), track_frames(track_numbers_.size(), 0);
  for (const Frame& frame : frames_) {
    std::map<std::size_t, double> of_object, of_track;
    for (const Pair& p : frame.pairs) of_object[p.object] += p.similarity, of_track[p.track] += p.similarity;
    for (const Pair& p : frame.pairs) {
      potential[{p.object, p.track}] += p.similarity / (of_object[p.object] + of_track[p.track] - p.similarity);
    }
    for (const std::size_t object : frame.objects) object_frames[object] += 1;
    for (const std::size_t track : frame.tracks) track_frames[track] += 1;
  }
  std::array<double, kLevels> hits{}, misses{}, false_alarms{};
  std::array<PairCounts, kLevels> matches;
  for (const Frame& frame : frames_) {
    const std::size_t columns = frame.tracks.size();
    std::vector<double> weights(frame.objects.size() * columns, 0), similarity(weights);
    for (const Pair& p : frame.pairs) {
      const std::size_t cell = position_of(frame.objects, p.object) * columns + position_of(frame.tracks, p.track);
      const double both = at(potential, p.object, p.track);
      weights[cell] = p.similarity * both / (object_frames[p.object] + track_frames[p.track] - both);
      similarity[cell] = p.similarity;
    }
    const auto pairs = best_pairs(weights, frame.objects.size(), columns);
    for (std::size_t level = 0; level < kLevels; ++level) {
      double matched = 0;
      for (const auto& [row, column] : pairs) {
        if (similarity[row * columns + column] < kStep * static_cast<double>(level + 1) - kRounding) continue;
        matched += 1;
        matches[level][{frame.objects[row], frame.tracks[column]}] += 1;
      }
      hits[level] += matched;
      misses[level] += static_cast<double>(frame.objects.size()) - matched;
      false_alarms[level] += static_cast<double>(columns) - matched;
    }
  }
  for (std::size_t level = 0; level < kLevels; ++level) {
    double association = 0;
    for (const auto& [pair, count] : matches[level]) {
      association += count * count / (object_frames[pair.first] + track_frames[pair.second] - count);
    }
    const double assa = association / std::max(1.0, hits[level]);
    const double deta = hits[level] / std::max(1.0, hits[level] + misses[level] + false_alarms[level]);
    const double hota = std::sqrt(deta * assa);
    scores.assa += assa / kLevels, scores.deta += deta / kLevels, scores.hota += hota / kLevels;
    if (level == kHalf) scores.hota50 = hota;
  }
}

void TrackScoring::score_identity(TrackScores& scores) const {
  PairCounts together;
  std::uint64_t tracked = 0;
  for (const Frame& frame : frames_) {
    tracked += frame.tracks.size();
    for (const Pair& p : frame.pairs) {
      if (p.similarity >= kLeastSimilarity) together[{p.object, p.track}] += 1;
    }
  }
  const std::size_t rows = object_numbers_.size(), columns = track_numbers_.size();
  std::vector<double> weights(rows * columns, 0);
  for (const auto& [pair, count] : together) weights[pair.first * columns + pair.second] = count;
  double right = 0;
  for (const auto& [row, column] : best_pairs(weights, rows, columns)) right += weights[row * columns + column];
  const auto all = static_cast<double>(scores.detections + tracked);
  scores.idf1 = all > 0 ? 2 * right / all : 0;
}

void TrackScoring::count_switches(TrackScores& scores) const {
  std::map<std::size_t, std::size_t> track_before;  // that each object had last
  std::map<std::size_t, std::size_t> last_frame;    // the pairs of the frame before
  std::map<std::size_t, bool> was_visible;          // whether each object could be seen in every frame since then
  for (const Frame& frame : frames_) {
    const std::size_t columns = frame.tracks.size();
    std::vector<double> weights(frame.objects.size() * columns, 0);
    for (const Pair& p : frame.pairs) {
      if (p.similarity < kLeastSimilarity) continue;
      const auto before = last_frame.find(p.object);
      const bool persists = before != last_frame.end() && before->second == p.track;
      weights[position_of(frame.objects, p.object) * columns + position_of(frame.tracks, p.track)] =
          p.similarity + (persists ? kPersistence : 0);
    }
    for (auto& [object, visible] : was_visible)
      visible = visible && std::ranges::find(frame.objects, object) != frame.objects.end();
    last_frame.clear();
    for (const auto& [row, column] : best_pairs(weights, frame.objects.size(), columns)) {
      const std::size_t object = frame.objects[row], track = frame.tracks[column];
      const auto before = track_before.find(object);
      if (before != track_before.end() && before->second != track) {
        ++scores.switches;
        if (was_visible[object]) ++scores.visible_switches;
      }
      track_before[object] = track, last_frame[object] = track, was_visible[object] = true;
    }
  }
}

TrackScores TrackScoring::scores() const {
  TrackScores scores;
  scores.frames = frames_.size();
  scores.objects = object_numbers_.size();
  scores.tracks = track_numbers_.size();
  for (const Frame& frame : frames_) scores.detections += frame.objects.size();
  score_hota(scores);
  score_identity(scores);
  count_switches(scores);
  return scores;
}

}  // namespace segserve::eval
