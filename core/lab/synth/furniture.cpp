// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/furniture.hpp"

namespace segserve::synth {
namespace {

Texture timber(Random& random) {
  Texture texture = random_texture(TextureKind::kWood, random);
  texture.base = lerp({0.38, 0.25, 0.15}, {0.88, 0.76, 0.6}, random.uniform());
  texture.second = 0.78 * texture.base;
  texture.scale = random.uniform(0.01, 0.025);
  return texture;
}

Texture timber_or_paint(Random& random) {
  return random.chance(0.65) ? timber(random) : random_texture(TextureKind::kPlain, random);
}

/// A round leg that gets wider towards its top.
Solid leg(double x, double y, double radius, double height, const Texture& texture) {
  return {{ShapeKind::kFrustum, 0.7 * radius, radius, height, 0}, translated({x, y, 0}), texture};
}

}  // namespace

Furniture random_table(Random& random) {
  const double x = random.uniform(0.55, 0.8), y = random.uniform(0.36, 0.45), height = random.uniform(0.7, 0.76);
  const double top = random.uniform(0.022, 0.035);
  const Texture wood = timber_or_paint(random);
  Furniture table{{{}, x, y, height}, {{translated({0, 0, height}), x - 0.02, y - 0.02}}};
  table.body.parts = {box_between({-x, -y, height - top}, {x, y, height}, wood)};
  for (const double side : {-1.0, 1.0}) {
    for (const double end : {-1.0, 1.0}) {
      table.body.parts.push_back(leg(end * (x - 0.06), side * (y - 0.06), 0.028, height - top, wood));
    }
  }
  return table;
}

Furniture random_chair(Random& random) {
  const double half = random.uniform(0.19, 0.22), seat = random.uniform(0.43, 0.47),
               height = random.uniform(0.82, 0.95);
  const Texture wood = timber_or_paint(random);
  const Texture cover = random.chance(0.5) ? wood : random_texture(TextureKind::kStripes, random);
  Furniture chair{{{}, half, half, height}, {}};
  chair.body.parts = {box_between({-half, -half, seat - 0.03}, {half, half, seat}, cover),
                      box_between({-half, -half, height - 0.22}, {half, -half + 0.02, height}, cover)};
  for (const double side : {-1.0, 1.0}) {
    const double x = side * (half - 0.018);
    chair.body.parts.push_back(leg(x, half - 0.02, 0.014, seat - 0.03, wood));
    chair.body.parts.push_back(box_between({x - 0.014, -half, 0}, {x + 0.014, -half + 0.028, height - 0.01}, wood));
  }
  return chair;
}

Furniture random_bookcase(Random& random) {
  const double x = random.uniform(0.38, 0.5), y = random.uniform(0.14, 0.18), height = random.uniform(1.2, 1.8);
  const double board = 0.018;
  const auto boards = static_cast<int>(height / 0.36);
  const double level = (height - board) / boards;
  const Texture wood = timber_or_paint(random);
  Furniture bookcase{{{}, x, y, height}, {}};
  bookcase.body.parts = {box_between({-x, -y, 0}, {-x + board, y, height}, wood),
                         box_between({x - board, -y, 0}, {x, y, height}, wood),
                         box_between({-x, -y, 0}, {x, -y + 0.008, height}, wood)};
  for (int i = 0; i <= boards; ++i) {
    const double z = i * level;
    bookcase.body.parts.push_back(box_between({-x, -y, z}, {x, y, z + board}, wood));
    const double clearance = i < boards ? level - board - 0.01 : 1e30;
    bookcase.shelves.push_back({translated({0, 0.01, z + board}), x - 0.03, y - 0.02, clearance});
  }
  bookcase.body.height = height + board;
  return bookcase;
}

Furniture random_sideboard(Random& random) {
  const double x = random.uniform(0.4, 0.75), y = random.uniform(0.2, 0.25), height = random.uniform(0.6, 0.95);
  const Texture wood = timber_or_paint(random);
  Texture doors = timber_or_paint(random);
  Furniture sideboard{{{}, x, y, height}, {{translated({0, 0, height}), x - 0.02, y - 0.02}}};
  sideboard.body.parts = {box_between({-x, -y, 0.06}, {x, y - 0.02, height}, wood)};
  const int count = 2 + static_cast<int>(random.below(2));
  for (int i = 0; i < count; ++i) {
    const double low = -x + 2 * x * i / count, high = low + 2 * x / count;
    sideboard.body.parts.push_back(
        box_between({low + 0.004, y - 0.02, 0.07}, {high - 0.004, y - 0.002, height - 0.02}, doors));
  }
  for (const double side : {-1.0, 1.0}) {
    for (const double end : {-1.0, 1.0}) {
      sideboard.body.parts.push_back(leg(end * (x - 0.04), side * (y - 0.05), 0.022, 0.07, wood));
    }
  }
  return sideboard;
}

Furniture random_armchair(Random& random) {
  const double x = random.uniform(0.36, 0.44), y = random.uniform(0.36, 0.42), height = random.uniform(0.75, 0.9);
  const Texture cloth = random_texture(random.chance(0.7) ? TextureKind::kPlain : TextureKind::kStripes, random);
  Furniture armchair{{{}, x, y, height}, {}};
  armchair.body.parts = {box_between({-x, -y, 0.05}, {x, y, 0.3}, cloth),
                         box_between({-x + 0.1, -y + 0.12, 0.3}, {x - 0.1, y, 0.43}, cloth),
                         box_between({-x, -y, 0.3}, {-x + 0.11, y, 0.58}, cloth),
                         box_between({x - 0.11, -y, 0.3}, {x, y, 0.58}, cloth),
                         box_between({-x, -y, 0.3}, {x, -y + 0.14, height}, cloth)};
  for (const double side : {-1.0, 1.0}) {
    for (const double end : {-1.0, 1.0}) {
      armchair.body.parts.push_back(leg(end * (x - 0.05), side * (y - 0.05), 0.02, 0.06, cloth));
    }
  }
  return armchair;
}

}  // namespace segserve::synth
