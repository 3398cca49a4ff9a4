// SPDX-License-Identifier: Apache-2.0
#include "core/lab/picture/dendrogram.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <map>
#include <string>
#include <utility>

#include "core/lab/picture/canvas.hpp"
#include "core/lab/picture/dendrogram_layout.hpp"
#include "core/lab/picture/legend.hpp"
#include "fmt/format.h"

namespace segserve::picture {
namespace {

constexpr std::uint32_t kGridColor = 0x2C2C32;
constexpr std::uint32_t kSharedColor = 0x8A8A94;  // of branches that hold several segments
constexpr std::uint32_t kJoinedColor = 0x5A5A62;
constexpr std::uint32_t kCutColor = 0x7CC4FF;

/// Segments with the points of their leaves.
std::vector<LegendEntry> entries_of(const MergeTree& tree, std::span<const std::uint32_t> segment_of_leaf,
                                    const SegmentColors& colors) {
  std::map<std::uint32_t, std::size_t> points;
  for (std::size_t leaf = 0; leaf < tree.leaf_count(); ++leaf) {
    if (segment_of_leaf[leaf] != 0) points[segment_of_leaf[leaf]] += tree.leaf_points[leaf];
  }
  std::vector<LegendEntry> entries;
  for (const auto& [label, count] : points) entries.push_back({label, colors(label), count});
  std::ranges::stable_sort(entries, std::ranges::greater(), &LegendEntry::points);
  return entries;
}

/// The height at which a cut to a number of regions lies: between the last merge that it applies and the next.
double height_of_regions(const MergeTree& tree, std::uint32_t regions) {
  const std::size_t rows = tree.row_count();
  const std::size_t applied = rows + 1 - std::min<std::size_t>(std::max(regions, 1U), rows + 1);
  const double below = applied == 0 ? 0.0 : tree.height[applied - 1];
  const double above = applied == rows ? (rows == 0 ? 1.0 : tree.height.back()) : tree.height[applied];
  return 0.5 * (below + above);
}

std::optional<double> cut_height(const MergeTree& tree, const DendrogramOptions& options) {
  if (options.regions) return height_of_regions(tree, *options.regions);
  return options.threshold;
}

class Drawing {
 public:
  Drawing(const MergeTree& tree, const DendrogramLayout& layout, std::span<const LegendEntry> entries,
          const DendrogramOptions& options)
      : tree_(tree),
        layout_(layout),
        image_(blank_image(std::max(options.width, kLeastWidth), std::max(options.height, kLeastHeight), kPanelColor)),
        canvas_(image_),
        legend_width_(legend_width(entries)),
        plot_{kLeft, kTop, static_cast<int>(image_.width) - kLeft - legend_width_,
              static_cast<int>(image_.height) - kTop - kBottom} {
    cut_ = cut_height(tree, options);
    if (!tree.height.empty()) top_ = std::max(tree.height.back(), cut_.value_or(0.0));
    if (top_ <= 0.0) top_ = 1.0;
    constexpr int kPensBetweenEnds = 5;
    pen_ = std::clamp(plot_.width / kPensBetweenEnds / static_cast<int>(std::max<std::size_t>(layout.ends, 1)), 1, 3);
    draw_legend(entries, {static_cast<int>(image_.width) - legend_width_, 0, legend_width_, plot_.top + plot_.height},
                canvas_);
  }

  void draw_axis();
  void draw_branches(const SegmentColors& colors);
  void draw_cut(const std::string& text);
  void draw_texts(const std::string& title, const std::string& note);
  Image take() && { return std::move(image_); }

 private:
  static constexpr int kLeft = 76;
  static constexpr int kTop = 44;
  static constexpr int kBottom = 60;
  static constexpr int kStrip = 14;  // the height of the colors below the tree
  static constexpr std::uint32_t kLeastWidth = 640;
  static constexpr std::uint32_t kLeastHeight = 320;

  int y_of(double height) const {
    return plot_.top + plot_.height - static_cast<int>(std::lround(height / top_ * plot_.height));
  }
  /// A horizontal or vertical line.
  void draw_line(Pixel from, Pixel to, std::uint32_t rgb);
  int x_of(double share) const { return plot_.left + static_cast<int>(std::lround(share * plot_.width)); }

  const MergeTree& tree_;
  const DendrogramLayout& layout_;
  Image image_;
  Canvas canvas_;
  int legend_width_;
  Box plot_;
  int pen_ = 1;       // the width of lines, pixels
  double top_ = 1.0;  // the height at the top of the plot
  std::optional<double> cut_;
};

void Drawing::draw_axis() {
  // Steps of 1, 2 or 5 times a power of ten, of which about eight fit.
  const double rough = top_ / 8.0;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  const double ratio = rough / power;
  const double step = power * (ratio < 1.5 ? 1.0 : ratio < 3.5 ? 2.0 : ratio < 7.5 ? 5.0 : 10.0);
  const int digits = std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9)));
  for (int i = 0; i * step <= top_ * (1.0 + 1e-9); ++i) {
    const int y = y_of(i * step);
    canvas_.line({plot_.left, y}, {plot_.left + plot_.width, y}, kGridColor);
    const std::string number = fmt::format("{:.{}f}", i * step, digits);
    canvas_.text({plot_.left - 10 - text_width(number), y - kTextHeight / 2}, number, kFaintTextColor);
  }
}

void Drawing::draw_line(Pixel from, Pixel to, std::uint32_t rgb) {
  const int left = std::min(from.x, to.x) - pen_ / 2;
  const int top = std::min(from.y, to.y) - pen_ / 2;
  canvas_.fill({left, top, std::abs(to.x - from.x) + pen_, std::abs(to.y - from.y) + pen_}, rgb);
}

void Drawing::draw_branches(const SegmentColors& colors) {
  for (const DendrogramBranch& branch : layout_.branches) {
    const std::uint32_t own = branch.segment ? colors(*branch.segment) : kSharedColor;
    const int x = x_of(branch.x);
    const int y = y_of(branch.height);
    if (branch.children) {
      const Pixel left{x_of(layout_.branches[branch.children->first].x), y};
      const Pixel right{x_of(layout_.branches[branch.children->second].x), y};
      if (branch.is_joined) {
        canvas_.line(left, right, kJoinedColor, 3);
      } else {
        draw_line(left, right, own);
      }
    } else {
      const int left = x_of(branch.left);
      canvas_.fill({left, y_of(0.0) + 4, std::max(x_of(branch.right) - left - 1, 1), kStrip}, own);
      draw_line({x, y}, {x, y_of(0.0) + 4}, own);
    }
    if (!branch.parent) continue;
    const DendrogramBranch& parent = layout_.branches[*branch.parent];
    draw_line({x, y}, {x, y_of(parent.height)}, own);
  }
}

void Drawing::draw_cut(const std::string& text) {
  if (!cut_) return;
  const int y = y_of(*cut_);
  canvas_.line({plot_.left, y}, {plot_.left + plot_.width, y}, kCutColor, 8);
  const int left = plot_.left + plot_.width - text_width(text) - 8;
  const int top = y - kTextHeight - 8 > plot_.top ? y - kTextHeight - 8 : y + 8;
  canvas_.fill({left - 4, top - 3, text_width(text) + 8, kTextHeight + 6}, kPanelColor);
  canvas_.text({left, top}, text, kCutColor);
}

void Drawing::draw_texts(const std::string& title, const std::string& note) {
  canvas_.text({plot_.left, 14}, shortened(title, plot_.width), kTextColor);
  canvas_.text({plot_.left, plot_.top + plot_.height + kStrip + 18}, shortened(note, plot_.width + legend_width_ - 12),
               kFaintTextColor);
}

std::string cut_text(const DendrogramOptions& options) {
  if (options.regions) return fmt::format("cut to {} regions", *options.regions);
  return options.threshold ? fmt::format("cut at {:.4g}", *options.threshold) : "";
}

}  // namespace

Image draw_dendrogram(const MergeTree& tree, std::span<const std::uint32_t> segment_of_leaf,
                      const SegmentColors& colors, const DendrogramOptions& options) {
  const std::vector<LegendEntry> entries = entries_of(tree, segment_of_leaf, colors);
  const auto segments = static_cast<std::uint32_t>(std::min<std::size_t>(entries.size(), kMostMergesDrawn));
  // Merges that are so low would lie on the axis.
  const double least_height = tree.height.empty() ? 0.0 : 0.005 * tree.height.back();
  const std::uint32_t merges = std::clamp(options.merges, segments, kMostMergesDrawn);
  const DendrogramLayout layout = lay_out(tree, segment_of_leaf, merges, least_height);
  Drawing drawing(tree, layout, entries, options);
  drawing.draw_axis();
  drawing.draw_branches(colors);
  drawing.draw_cut(cut_text(options));
  const std::string title = tree.leaf_count() == 0
                                ? "The merge tree has no supervoxels."
                                : fmt::format("Merge tree of {} supervoxels: height of each merge", tree.leaf_count());
  std::string note;
  if (layout.collapsed_leaves > 0) {
    note = fmt::format("{} supervoxels are not drawn one by one: they merge to {} branches below {:.2g}.",
                       layout.collapsed_leaves, layout.collapsed_branches, layout.collapsed_below);
  }
  drawing.draw_texts(title, note);
  return std::move(drawing).take();
}

std::vector<std::uint32_t> segments_of_leaves(std::size_t leaves, std::span<const std::uint32_t> supervoxels,
                                              std::span<const std::uint32_t> labels) {
  std::vector<std::uint32_t> segments(leaves);
  for (std::size_t i = 0; i < supervoxels.size(); ++i) {
    if (supervoxels[i] > 0 && supervoxels[i] <= leaves) segments[supervoxels[i] - 1] = labels[i];
  }
  return segments;
}

}  // namespace segserve::picture
