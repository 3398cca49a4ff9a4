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

Furniture random_sofa(Random& random) {
  const int seats = 2 + static_cast<int>(random.below(2));
  const double seat = random.uniform(0.27, 0.32), arm = random.uniform(0.1, 0.16), x = seats * seat + arm;
  const double y = random.uniform(0.4, 0.46), height = random.uniform(0.72, 0.88);
  const Texture cloth = random_texture(random.chance(0.7) ? TextureKind::kPlain : TextureKind::kStripes, random);
  Furniture sofa{{{}, x, y, height}, {}};
  sofa.body.parts = {box_between({-x, -y, 0.06}, {x, y, 0.3}, cloth),
                     box_between({-x, -y, 0.3}, {-x + arm, y, 0.58}, cloth),
                     box_between({x - arm, -y, 0.3}, {x, y, 0.58}, cloth),
                     box_between({-x + arm, -y, 0.3}, {x - arm, -y + 0.16, height}, cloth)};
  for (int i = 0; i < seats; ++i) {
    const double low = -x + arm + 2 * seat * i, high = low + 2 * seat;
    sofa.body.parts.push_back(box_between({low + 0.006, -y + 0.16, 0.3}, {high - 0.006, y - 0.01, 0.44}, cloth));
  }
  for (const double side : {-1.0, 1.0}) {
    for (const double end : {-1.0, 1.0}) {
      sofa.body.parts.push_back(leg(end * (x - 0.06), side * (y - 0.06), 0.025, 0.07, cloth));
    }
  }
  return sofa;
}

Furniture random_bed(Random& random) {
  const double x = random.uniform(0.45, 0.8), y = random.uniform(0.98, 1.05), height = random.uniform(0.75, 1.0);
  const Texture wood = timber_or_paint(random);
  const Texture sheet = random_texture(random.chance(0.5) ? TextureKind::kPlain : TextureKind::kStripes, random);
  Furniture bed{{{}, x, y, height}, {}};
  bed.body.parts = {box_between({-x, -y + 0.05, 0.2}, {x, y, 0.32}, wood),
                    box_between({-x, -y, 0.1}, {x, -y + 0.05, height}, wood),
                    box_between({-x + 0.03, -y + 0.06, 0.32}, {x - 0.03, y - 0.02, 0.5}, sheet),
                    {{ShapeKind::kEllipsoid, 0.3, 0.2, 0.09, 0}, translated({0, -y + 0.32, 0.53}), sheet}};
  for (const double side : {-1.0, 1.0}) {
    for (const double end : {-1.0, 1.0}) {
      bed.body.parts.push_back(leg(end * (x - 0.05), side * (y - 0.05), 0.03, 0.22, wood));
    }
  }
  return bed;
}

Furniture random_desk(Random& random) {
  const double x = random.uniform(0.6, 0.8), y = random.uniform(0.32, 0.4), height = random.uniform(0.71, 0.75);
  const Texture wood = timber_or_paint(random);
  Furniture desk{{{}, x, y, height}, {{translated({0, 0, height}), x - 0.03, y - 0.03}}};
  desk.body.parts = {box_between({-x, -y, height - 0.025}, {x, y, height}, wood),
                     box_between({-x + 0.02, -y + 0.02, 0}, {-x + 0.04, y - 0.02, height - 0.025}, wood),
                     box_between({x - 0.42, -y + 0.02, 0.03}, {x - 0.02, y - 0.04, height - 0.025}, wood),
                     box_between({-x + 0.04, -y + 0.05, height - 0.3}, {x - 0.42, -y + 0.065, height - 0.025}, wood)};
  constexpr int kDrawers = 3;
  for (int i = 0; i < kDrawers; ++i) {
    const double low = 0.05 + (height - 0.09) * i / kDrawers, high = 0.05 + (height - 0.09) * (i + 1) / kDrawers;
    desk.body.parts.push_back(box_between({x - 0.415, y - 0.04, low}, {x - 0.025, y - 0.022, high - 0.01}, wood));
  }
  return desk;
}

Furniture random_office_chair(Random& random) {
  const double half = random.uniform(0.22, 0.25), seat = random.uniform(0.44, 0.52), height = random.uniform(0.9, 1.1);
  const double reach = 0.31, turns = random.uniform();
  const Texture plastic{.kind = TextureKind::kPlain, .base = {0.15, 0.15, 0.16}};
  const Texture cloth = random_texture(TextureKind::kPlain, random);
  Furniture chair{{{}, reach + 0.03, reach + 0.03, height}, {}};
  chair.body.parts = {box_between({-half, -half, seat - 0.07}, {half, half, seat}, cloth),
                      box_between({-half, -half - 0.04, seat + 0.12}, {half, -half + 0.03, height}, cloth),
                      box_between({-0.04, -half - 0.05, seat - 0.06}, {0.04, -half - 0.02, seat + 0.3}, plastic),
                      {{ShapeKind::kFrustum, 0.03, 0.025, seat - 0.13, 0}, translated({0, 0, 0.06}), plastic}};
  for (int i = 0; i < 5; ++i) {
    const double angle = 2 * kPi * (turns + i / 5.0);
    const Vec3 tip{reach * math::cos(angle), reach * math::sin(angle), 0.055};
    const Vec3 arm = tip - Vec3{0, 0, 0.1};
    chair.body.parts.push_back(
        {{ShapeKind::kFrustum, 0.022, 0.018, norm(arm), 0}, with_z_along(arm, {0, 0, 0.1}), plastic});
    chair.body.parts.push_back(
        {{ShapeKind::kEllipsoid, 0.028, 0.028, 0.028, 0}, translated({tip.x, tip.y, 0.028}), plastic});
  }
  return chair;
}

Furniture random_stool(Random& random) {
  const double radius = random.uniform(0.15, 0.19), height = random.uniform(0.42, 0.5), turns = random.uniform();
  const Texture wood = timber_or_paint(random);
  Furniture stool{{{}, radius, radius, height}, {{translated({0, 0, height}), 0.6 * radius, 0.6 * radius}}};
  stool.body.parts = {{{ShapeKind::kFrustum, radius, radius, 0.03, 0}, translated({0, 0, height - 0.03}), wood}};
  for (int i = 0; i < 3; ++i) {
    const double angle = 2 * kPi * (turns + i / 3.0);
    stool.body.parts.push_back(
        leg((radius - 0.03) * math::cos(angle), (radius - 0.03) * math::sin(angle), 0.016, height - 0.03, wood));
  }
  return stool;
}

Furniture random_floor_lamp(Random& random) {
  const double foot = random.uniform(0.12, 0.16), shade = random.uniform(0.14, 0.22), height = random.uniform(1.4, 1.8);
  const double half = foot > shade ? foot : shade;
  const Texture metal{.kind = TextureKind::kPlain, .base = {0.3, 0.3, 0.32}};
  const Texture cloth = random_texture(TextureKind::kPlain, random);
  Furniture lamp{{{}, half, half, height}, {}};
  lamp.body.parts = {{{ShapeKind::kFrustum, foot, 0.8 * foot, 0.025, 0}, {}, metal},
                     {{ShapeKind::kFrustum, 0.012, 0.012, height - 0.1, 0}, {}, metal},
                     {{ShapeKind::kTube, shade, 0.7 * shade, 0.26, 0.004}, translated({0, 0, height - 0.26}), cloth},
                     box_between({-0.85 * shade, -0.004, height - 0.12}, {0.85 * shade, 0.004, height - 0.11}, metal)};
  return lamp;
}

}  // namespace segserve::synth
