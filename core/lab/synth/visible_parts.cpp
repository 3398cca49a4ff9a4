// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/visible_parts.hpp"

#include <algorithm>
#include <numeric>

namespace segserve::synth {
namespace {

/// Union-find.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), 0U); }

  std::uint32_t root(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  /// The smaller index becomes the root, so that the root of a part is its first pixel.
  void join(std::uint32_t a, std::uint32_t b) {
    a = root(a);
    b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

/// A connected part of an object.
struct Part {
  std::uint32_t object, size, first;
};

/// The parts by object, then by descending size.
std::vector<Part> parts_of(const std::vector<std::uint32_t>& label, DisjointSets& pixels) {
  std::vector<std::uint32_t> size(label.size(), 0);
  for (std::uint32_t i = 0; i < label.size(); ++i) {
    if (label[i] >= 10) ++size[pixels.root(i)];
  }
  std::vector<Part> parts;
  for (std::uint32_t i = 0; i < label.size(); ++i) {
    if (size[i] > 0) parts.push_back({label[i], size[i], i});
  }
  std::sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) {
    if (a.object != b.object) return a.object < b.object;
    return a.size != b.size ? a.size > b.size : a.first < b.first;
  });
  return parts;
}

}  // namespace

void label_visible_parts(std::uint32_t width, std::uint32_t height, std::uint32_t smallest,
                         std::vector<std::uint32_t>& label) {
  DisjointSets pixels(label.size());
  for (std::uint32_t v = 0, i = 0; v < height; ++v) {
    for (std::uint32_t u = 0; u < width; ++u, ++i) {
      if (label[i] < 10) continue;
      const auto join_if_same = [&](std::uint32_t j) {
        if (label[j] == label[i]) pixels.join(i, j);
      };
      if (u > 0) join_if_same(i - 1);
      if (v > 0) join_if_same(i - width);
      if (v > 0 && u > 0) join_if_same(i - width - 1);
      if (v > 0 && u + 1 < width) join_if_same(i - width + 1);
    }
  }
  std::vector<std::uint32_t> new_label(label.size(), 0);
  std::uint32_t rank = 0;
  std::uint32_t object = 0;
  for (const Part& part : parts_of(label, pixels)) {
    rank = part.object == object ? rank + 1 : 0;
    object = part.object;
    new_label[part.first] = object + (part.size < smallest || rank > 9 ? 0 : rank);
  }
  for (std::uint32_t i = 0; i < label.size(); ++i) {
    if (label[i] >= 10) label[i] = new_label[pixels.root(i)];
  }
}

}  // namespace segserve::synth
