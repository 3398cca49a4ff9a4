// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/street_scene.hpp"

#include <algorithm>

#include "core/lab/synth/arrangement.hpp"
#include "core/lab/synth/street_things.hpp"
#include "core/lab/synth/value_noise.hpp"

namespace segserve::synth {
namespace {

constexpr double kHalfLength = 60;  // of the street, in meters
constexpr double kSidewalk = 2.8;   // meters in front of the facades

class StreetBuilder {
 public:
  explicit StreetBuilder(std::uint64_t seed) : random_(seed), facade_(random_.uniform(8.2, 10)) {
    scene_.seed = seed;
    add_slab({-150, -60, -1}, {150, 60, 0}, kGround);
    for (const double side : {1.0, -1.0}) add_facades(side);
    street_.occupy({0, 0, 0, 4, 2.5, 0, 3});  // the sensor's own car
    for (const double side : {1.0, -1.0}) {
      add_row_of_posts_and_trees(side);
      add_parked_cars(side);
      add_moving_cars(side);
    }
    const std::uint32_t pedestrians = 8 + random_.below(8);
    for (std::uint32_t i = 0; i < pedestrians; ++i) add_pedestrian();
  }
  StreetScene take() { return std::move(scene_); }

 private:
  void add_part(const Solid& part, double depth_of_leaves) {
    scene_.world.push_back(part);
    scene_.depth_of_leaves.push_back(depth_of_leaves);
  }
  void add_slab(const Vec3& low, const Vec3& high, std::uint32_t label) {
    add_part(box_between(low, high, {}, label), 0);
  }

  /// Four houses with gaps between them, so that each facade is a surface of its own.
  void add_facades(double side) {
    std::uint32_t label = side > 0 ? 2 : 6;
    double left = -random_.uniform(36, 44);
    for (int house = 0; house < 4; ++house) {
      const double length = random_.uniform(14, 21), height = random_.uniform(7, 16);
      const double front = facade_ + random_.uniform(0, 1.2);
      const auto slab = [&](double x0, double x1, double y0, double y1, double z0, double z1) {
        add_slab({x0, std::min(side * y0, side * y1), z0}, {x1, std::max(side * y0, side * y1), z1}, label);
      };
      slab(left, left + length, front, front + 10, 0, height);
      if (random_.chance(0.5)) {
        for (double x = left + 2; x + 3 < left + length; x += 5)
          slab(x, x + 2.5, front - 0.9, front, 3, 4.1);  // balconies
      }
      left += length + random_.uniform(1.5, 4);
      ++label;
    }
  }

  /// Places a thing that stands on the street, unless it would hit another one. The last `leaves` of its parts are a
  /// crown.
  bool add(const HouseholdObject& thing, double x, double y, double turns, double gap, std::size_t leaves = 0) {
    const Arrangement::Footprint footprint{x, y, turns, thing.half_x, thing.half_y, 0, thing.height};
    if (!street_.is_free(footprint, gap)) return false;
    street_.occupy(footprint);
    const Pose pose = rotated(turns, {x, y, 0});
    for (std::size_t i = 0; i < thing.parts.size(); ++i) {
      const Solid& part = thing.parts[i];
      add_part({part.shape, pose * part.pose, part.texture, label_}, i + leaves >= thing.parts.size() ? 0.5 : 0);
    }
    label_ += 10;
    return true;
  }

  void add_row_of_posts_and_trees(double side) {
    const double y = side * (facade_ - kSidewalk + 0.4);
    bool is_post = random_.chance(0.5);
    for (double x = -kHalfLength + random_.uniform(0, 10); x < kHalfLength; x += random_.uniform(8, 13)) {
      if (is_post) {
        add(random_lamp_post(random_), x, y, side > 0 ? 0.75 : 0.25, 0.3);
      } else {
        const Tree tree = random_tree(random_);
        add(tree.body, x, y, random_.uniform(), 0.3, tree.crown);
      }
      is_post = !is_post;
    }
  }

  HouseholdObject random_vehicle() { return random_.chance(0.2) ? random_van(random_) : random_car(random_); }

  void add_parked_cars(double side) {
    const double y = side * (facade_ - kSidewalk - 1.15);
    for (double x = -45 + random_.uniform(0, 5); x < 45; x += random_.uniform(5.8, 8)) {
      const HouseholdObject vehicle = random_vehicle();
      const double askew = random_.uniform(-0.008, 0.008);
      if (random_.chance(0.65)) add(vehicle, x, y, (side > 0 ? 0.5 : 0) + askew, 0.4);
    }
  }

  void add_moving_cars(double side) {
    for (double x = -50 + random_.uniform(0, 20); x < 50; x += random_.uniform(14, 30)) {
      const HouseholdObject vehicle = random_vehicle();
      add(vehicle, x, side * 1.9, side > 0 ? 0.5 : 0, 1);
    }
  }

  /// Most pedestrians walk along the sidewalk, some cross the street.
  void add_pedestrian() {
    const HouseholdObject person = random_pedestrian(random_);
    const bool crosses = random_.chance(0.2);
    for (int i = 0; i < 20; ++i) {
      const double side = random_.chance(0.5) ? 1 : -1;
      const double x = random_.uniform(-25, 25);
      const double y = crosses ? random_.uniform(-4, 4) : side * (facade_ - random_.uniform(0.5, kSidewalk - 0.9));
      const double turns = crosses ? 0.25 : random_.chance(0.5) ? 0.5 : 0;
      if (add(person, x, y, turns + random_.uniform(-0.05, 0.05), 0.4)) return;
    }
  }

  Random random_;
  double facade_;  // distance of the facades from the middle of the street
  StreetScene scene_;
  Arrangement street_;
  std::uint32_t label_ = 20;
};

}  // namespace

StreetScene arrange_street(std::uint64_t seed) { return StreetBuilder(seed).take(); }

double ground_height(std::uint64_t seed, double x, double y) {
  constexpr double kWave = 8, kAmplitude = 0.12;  // meters
  return kAmplitude * (fractal_noise(x / kWave, y / kWave, seed + 5) - 0.5);
}

}  // namespace segserve::synth
