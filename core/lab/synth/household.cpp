// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/household.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace segserve::synth {
namespace {

constexpr Pose kUpright{};

Shape box(double a, double b, double c) { return {ShapeKind::kBox, a, b, c, 0}; }
Shape frustum(double bottom, double top, double height) { return {ShapeKind::kFrustum, bottom, top, height, 0}; }
Shape cylinder(double radius, double height) { return frustum(radius, radius, height); }

Texture plain(Random& random) { return random_texture(TextureKind::kPlain, random); }
Texture metal(Random& random) {
  Texture texture = plain(random);
  const double gray = random.uniform(0.6, 0.75);
  texture.base = {gray, gray, gray + 0.02};
  return texture;
}
Texture wooden(Random& random) {
  Texture texture = random_texture(TextureKind::kWood, random);
  const double light = random.uniform(0.0, 1.0);
  texture.base = lerp({0.45, 0.29, 0.17}, {0.85, 0.68, 0.48}, light);
  texture.second = 0.72 * texture.base;
  return texture;
}

/// A box with half edges a >= b >= c in one of its three stable poses.
HouseholdObject carton(double a, double b, double c, const Texture& texture, Random& random) {
  std::array<double, 3> half{a, b, c};
  switch (random.below(3)) {
    case 0:  // flat
      half = {a, b, c};
      break;
    case 1:  // upright
      half = {b, c, a};
      break;
    default:  // on its long side
      half = {a, c, b};
      break;
  }
  const auto [x, y, z] = half;
  return {{{box(x, y, z), translated({0, 0, z}), texture}}, x, y, 2 * z, x, y};
}

HouseholdObject cereal_box(Random& random) {
  const double a = random.uniform(0.09, 0.14), b = random.uniform(0.06, 0.095), c = random.uniform(0.022, 0.038);
  return carton(a, b, c, random_texture(TextureKind::kPrint, random), random);
}

HouseholdObject small_carton(Random& random) {
  const double a = random.uniform(0.045, 0.08), b = random.uniform(0.03, 0.045), c = random.uniform(0.02, 0.03);
  return carton(a, b, c, random_texture(random), random);
}

HouseholdObject book(Random& random) {
  const double a = random.uniform(0.09, 0.14), b = random.uniform(0.065, 0.1), c = random.uniform(0.008, 0.022);
  const Texture cover = random_texture(random.chance(0.6) ? TextureKind::kPrint : TextureKind::kPlain, random);
  Texture paper = plain(random);
  paper.base = {0.9, 0.88, 0.8};
  const double board = 0.0015;
  HouseholdObject book{{}, a, b, 2 * c, a, b};
  book.parts = {{box(a, b, board), translated({0, 0, board}), cover},
                {box(a, b, board), translated({0, 0, 2 * c - board}), cover},
                {box(a - 0.004, b - 0.003, c - 2 * board), translated({0, 0.001, c}), paper},
                {box(a, board, c), translated({0, -b + board, c}), cover}};
  return book;
}

/// A standing object with a round foot. `top` is the radius of the flat area on its top, or 0.
HouseholdObject stand(std::vector<Solid> parts, double radius, double height, double top) {
  return {std::move(parts), radius, radius, height, 0.7 * top, 0.7 * top};
}

/// Lays a standing object on its side, along y and centered on the z axis.
HouseholdObject lay(const HouseholdObject& standing, double radius) {
  HouseholdObject lying{{}, radius, standing.height / 2, 2 * radius, 0, 0};
  const Pose pose{{1, 0, 0}, {0, 0, 1}, {0, -1, 0}, {0, standing.height / 2, radius}};
  for (const Solid& part : standing.parts) lying.parts.push_back({part.shape, pose * part.pose, part.texture});
  return lying;
}

HouseholdObject can(Random& random) {
  const double r = random.uniform(0.03, 0.052), h = random.uniform(0.08, 0.15);
  const Texture label = random_texture(random.chance(0.7) ? TextureKind::kPrint : TextureKind::kStripes, random);
  const Texture lid = metal(random);
  const double rim = 0.003;
  const HouseholdObject standing = stand({{cylinder(r, rim), kUpright, lid},
                                          {cylinder(0.98 * r, h - 2 * rim), translated({0, 0, rim}), label},
                                          {cylinder(r, rim), translated({0, 0, h - rim}), lid}},
                                         r, h, r);
  return random.chance(0.3) ? lay(standing, r) : standing;
}

HouseholdObject tin(Random& random) {
  const double r = random.uniform(0.065, 0.1), h = random.uniform(0.045, 0.09);
  const Texture side = random_texture(random);
  const Texture lid = random_texture(random.chance(0.5) ? TextureKind::kPrint : TextureKind::kPlain, random);
  return stand({{cylinder(0.97 * r, h), kUpright, side}, {cylinder(r, 0.018), translated({0, 0, h - 0.017}), lid}}, r,
               h + 0.001, r);
}

HouseholdObject bottle(Random& random) {
  const double r = random.uniform(0.028, 0.045), body = random.uniform(0.1, 0.16), neck = random.uniform(0.011, 0.016);
  const double shoulder = random.uniform(0.03, 0.055), top = body + shoulder + 0.03;
  const Texture glass = plain(random);
  const Texture label = random_texture(TextureKind::kPrint, random);
  const Texture cap = plain(random);
  const HouseholdObject standing = stand({{cylinder(r, body), kUpright, glass},
                                          {cylinder(1.01 * r, 0.55 * body), translated({0, 0, 0.2 * body}), label},
                                          {frustum(r, neck, shoulder), translated({0, 0, body}), glass},
                                          {cylinder(neck, 0.03), translated({0, 0, body + shoulder}), glass},
                                          {cylinder(1.15 * neck, 0.016), translated({0, 0, top - 0.01}), cap}},
                                         1.01 * r, top + 0.006, 0);
  return random.chance(0.25) ? lay(standing, 1.01 * r) : standing;
}

/// Adds a handle: half a ring of short rods in the plane y = 0, beyond x = `from`.
void add_handle(std::vector<Solid>& parts, double from, double low, double high, double reach, double thickness,
                const Texture& texture) {
  constexpr int kRods = 7;
  const auto point = [&](int i) {
    const double turns = 0.5 * i / kRods - 0.25;
    const double s = math::sin(2 * kPi * turns), c = math::cos(2 * kPi * turns);
    return Vec3{from + reach * c, 0, (low + high) / 2 + (high - low) / 2 * s};
  };
  for (int i = 0; i < kRods; ++i) {
    const Vec3 rod = point(i + 1) - point(i);
    parts.push_back({cylinder(thickness, norm(rod) + 0.4 * thickness), with_z_along(rod, point(i)), texture});
  }
}

HouseholdObject mug(Random& random) {
  const double r = random.uniform(0.036, 0.046), h = random.uniform(0.075, 0.11), foot = r * random.uniform(0.75, 1.0);
  const Texture glaze = random_texture(random);
  const Texture handle = {.base = glaze.base, .seed = glaze.seed};
  HouseholdObject mug = stand({{{ShapeKind::kCup, foot, r, h, 0.004}, kUpright, glaze}}, r, h, 0);
  add_handle(mug.parts, foot + 0.6 * (r - foot) - 0.002, 0.2 * h, 0.85 * h, 0.032, 0.0055, handle);
  for (Solid& part : mug.parts) part.pose.origin.x -= 0.018;
  mug.half_x = r + 0.02;
  return mug;
}

HouseholdObject bowl(Random& random) {
  const double sphere = random.uniform(0.075, 0.11), h = sphere * random.uniform(0.5, 0.8);
  const double foot = 0.008, rim = std::sqrt(h * (2 * sphere - h));
  const Texture glaze = random_texture(random.chance(0.6) ? TextureKind::kPlain : TextureKind::kStripes, random);
  return stand({{{ShapeKind::kBowl, sphere, h, 0, 0.0045}, translated({0, 0, foot - 0.003}), glaze},
                {cylinder(0.4 * rim, foot), kUpright, glaze}},
               rim, h + foot, 0);
}

HouseholdObject ball(Random& random) {
  const double r = random.uniform(0.03, 0.085);
  const Texture skin = random_texture(random);
  return {{{{ShapeKind::kEllipsoid, r, r, r, 0}, translated({0, 0, r}), skin}}, r, r, 2 * r, 0, 0};
}

HouseholdObject fruit(Random& random) {
  const double a = random.uniform(0.03, 0.065), b = a * random.uniform(0.65, 1.0), c = b * random.uniform(0.85, 1.0);
  const Texture skin = random_texture(random.chance(0.5) ? TextureKind::kSpeckle : TextureKind::kPlain, random);
  return {{{{ShapeKind::kEllipsoid, a, b, c, 0}, translated({0, 0, c}), skin}}, a, b, 2 * c, 0, 0};
}

HouseholdObject flowerpot(Random& random) {
  const double r = random.uniform(0.05, 0.08), h = random.uniform(0.07, 0.12);
  const Texture clay = random_texture(random.chance(0.6) ? TextureKind::kPlain : TextureKind::kSpeckle, random);
  return stand({{{ShapeKind::kCup, 0.68 * r, 0.93 * r, h, 0.006}, kUpright, clay},
                {{ShapeKind::kTube, r, r, 0.22 * h, 0.008}, translated({0, 0, 0.8 * h}), clay}},
               r, 1.02 * h, 0);
}

HouseholdObject cone(Random& random) {
  const double r = random.uniform(0.04, 0.075), h = random.uniform(0.09, 0.2);
  const Texture paper = random_texture(random.chance(0.6) ? TextureKind::kStripes : TextureKind::kChecks, random);
  return stand({{frustum(r, random.uniform(0.0, 0.4) * r, h), kUpright, paper}}, r, h, 0);
}

HouseholdObject tape_roll(Random& random) {
  const double r = random.uniform(0.04, 0.06), h = random.uniform(0.02, 0.05);
  return stand({{{ShapeKind::kTube, r, r, h, 0.012}, kUpright, plain(random)}}, r, h, 0);
}

HouseholdObject pan(Random& random) {
  const double r = random.uniform(0.08, 0.11), h = random.uniform(0.035, 0.06), grip = random.uniform(0.12, 0.17);
  const Texture iron = plain(random);
  const Texture handle = random.chance(0.5) ? wooden(random) : metal(random);
  const double shift = -grip / 2;
  HouseholdObject pan{{}, r + grip / 2, r, h + 0.02, 0, 0};
  pan.parts = {{{ShapeKind::kCup, 0.85 * r, r, h, 0.004}, translated({shift, 0, 0}), iron},
               {cylinder(0.009, grip + 0.005), with_z_along({1, 0, 0.06}, {shift + r - 0.008, 0, h - 0.012}), handle}};
  return pan;
}

HouseholdObject candlestick(Random& random) {
  const double h = random.uniform(0.14, 0.24), foot = random.uniform(0.035, 0.05);
  const Texture brass = random.chance(0.5) ? metal(random) : wooden(random);
  const Texture wax = plain(random);
  return stand({{frustum(foot, 0.7 * foot, 0.014), kUpright, brass},
                {cylinder(0.008, 0.6 * h), translated({0, 0, 0.01}), brass},
                {frustum(0.01, 0.02, 0.02), translated({0, 0, 0.6 * h}), brass},
                {cylinder(0.0105, 0.4 * h - 0.02), translated({0, 0, 0.6 * h + 0.02}), wax}},
               foot, h, 0);
}

HouseholdObject pole(Random& random) {
  const double r = random.uniform(0.007, 0.014), h = random.uniform(0.16, 0.3);
  const Texture surface = random.chance(0.5) ? wooden(random) : random_texture(TextureKind::kStripes, random);
  return lay(stand({{cylinder(r, h), kUpright, surface}}, r, h, 0), r);
}

HouseholdObject wooden_block(Random& random) {
  const double a = random.uniform(0.05, 0.09), b = random.uniform(0.03, 0.05), c = random.uniform(0.02, 0.03);
  return carton(a, b, c, wooden(random), random);
}

/// A glass or a beaker.
HouseholdObject cup(Random& random) {
  const double r = random.uniform(0.032, 0.045), h = random.uniform(0.07, 0.13), foot = r * random.uniform(0.65, 1.0);
  return stand({{{ShapeKind::kCup, foot, r, h, 0.003}, kUpright, random_texture(random)}}, r, h, 0);
}

HouseholdObject plate(Random& random) {
  const double r = random.uniform(0.08, 0.13), h = random.uniform(0.018, 0.03);
  return stand({{{ShapeKind::kCup, 0.6 * r, r, h, 0.004}, kUpright, plain(random)}}, r, h, 0);
}

/// A flap that hangs from the middle of an edge, in the direction `away` from it, and rises by `rise` meters a meter.
Solid flap(const Vec3& edge, const Vec3& away, double rise, double length, double half_width, double thickness,
           const Texture& texture) {
  const Vec3 x = unit(away + Vec3{0, 0, rise}), y = cross({0, 0, 1}, away);
  const Pose pose{x, y, cross(x, y), edge + 0.5 * length * x};
  return {box(length / 2, half_width, thickness / 2), pose, texture};
}

/// A box without a lid; some have flaps on two or four sides.
HouseholdObject open_box(Random& random) {
  const double a = random.uniform(0.05, 0.12), b = a * random.uniform(0.6, 1.0), h = random.uniform(0.05, 0.13);
  const double wall = random.uniform(0.003, 0.006);
  const Texture outside = random_texture(random.chance(0.5) ? TextureKind::kPrint : TextureKind::kPlain, random);
  HouseholdObject result{{}, a, b, h, 0, 0};
  result.parts = {box_between({-a, -b, 0}, {a, b, wall}, outside),
                  box_between({-a, -b, wall}, {-a + wall, b, h}, outside),
                  box_between({a - wall, -b, wall}, {a, b, h}, outside),
                  box_between({-a + wall, -b, wall}, {a - wall, -b + wall, h}, outside),
                  box_between({-a + wall, b - wall, wall}, {a - wall, b, h}, outside)};
  const std::uint32_t flaps = 2 * random.below(3);
  const double length = random.uniform(0.5, 0.9) * b, thin = 0.003;
  for (std::uint32_t i = 0; i < flaps; ++i) {
    const double side = i % 2 == 0 ? 1 : -1, rise = random.uniform(-0.4, 0.8);
    const bool along_x = i < 2;
    const Vec3 away = along_x ? Vec3{side, 0, 0} : Vec3{0, side, 0};
    const Vec3 edge = (along_x ? a - thin : b - thin) * away + Vec3{0, 0, h - thin};
    result.parts.push_back(flap(edge, away, rise, length, 0.96 * (along_x ? b : a), thin, outside));
    double& half = along_x ? result.half_x : result.half_y;
    half = std::max(half, (along_x ? a : b) + length);
    result.height = std::max(result.height, h + std::max(0.0, rise) * length + thin);
  }
  return result;
}

/// A cable that lies in waves, 5 to 9 mm thick.
HouseholdObject cable(Random& random) {
  constexpr int kRods = 36;
  const double length = random.uniform(0.22, 0.38), width = random.uniform(0.03, 0.07),
               r = random.uniform(0.0025, 0.0045);
  const double waves = random.uniform(1.0, 2.5), phase = random.uniform();
  const Texture rubber = plain(random);
  const auto point = [&](int i) {
    const double along = static_cast<double>(i) / kRods;
    return Vec3{(along - 0.5) * length, width * math::sin(2 * kPi * (waves * along + phase)), r};
  };
  HouseholdObject result{{}, length / 2 + r, width + r, 2 * r, 0, 0};
  for (int i = 0; i <= kRods; ++i) {
    result.parts.push_back({{ShapeKind::kEllipsoid, r, r, r, 0}, translated(point(i)), rubber});
    if (i == kRods) break;
    const Vec3 rod = point(i + 1) - point(i);
    result.parts.push_back({cylinder(r, norm(rod)), with_z_along(rod, point(i)), rubber});
  }
  return result;
}

}  // namespace

HouseholdObject random_household_object(Random& random) {
  using Maker = HouseholdObject (*)(Random&);
  // Boxes and cans are listed more than once, because they are the most frequent objects on real tables.
  static constexpr std::array<Maker, 22> kMakers{
      cereal_box, cereal_box, cereal_box, small_carton, small_carton, book,       wooden_block, can,
      can,        tin,        bottle,     bottle,       mug,          mug,        bowl,         ball,
      fruit,      flowerpot,  cone,       tape_roll,    pan,          candlestick};
  const std::uint32_t choice = random.below(kMakers.size() + 1);
  return choice < kMakers.size() ? kMakers[choice](random) : pole(random);
}

HouseholdObject random_hollow_object(Random& random) {
  using Maker = HouseholdObject (*)(Random&);
  static constexpr std::array<Maker, 13> kMakers{bowl,     bowl,     mug,   mug,   cup,       plate, open_box,
                                                 open_box, open_box, cable, cable, flowerpot, pan};
  return kMakers[random.below(kMakers.size())](random);
}

HouseholdObject random_compact_object(Random& random) {
  using Maker = HouseholdObject (*)(Random&);
  static constexpr std::array<Maker, 10> kMakers{cereal_box, cereal_box, small_carton, book, wooden_block,
                                                 can,        tin,        bottle,       ball, fruit};
  return kMakers[random.below(kMakers.size())](random);
}

}  // namespace segserve::synth
