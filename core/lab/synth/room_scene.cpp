// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/room_scene.hpp"

#include <algorithm>
#include <cmath>

#include "core/lab/synth/furniture.hpp"

namespace segserve::synth {
namespace {

constexpr double kWallHeight = 2.4;  // meters

class RoomBuilder {
 public:
  explicit RoomBuilder(const RoomOptions& options)
      : random_(options.seed), half_x_(1.65 * options.size), half_y_(1.4 * options.size) {
    const double rooms = options.size * options.size;
    add_shell();
    const auto count = [rooms](double per_room) {
      return std::max(1, static_cast<int>(std::floor(per_room * rooms + 0.5)));
    };
    for (int i = 0; i < count(1); ++i) add_table_group();
    for (int i = 0; i < count(1.6); ++i) add_at_wall(random_bookcase(random_));
    for (int i = 0; i < count(1); ++i) add_at_wall(random_sideboard(random_));
    for (int i = 0; i < count(0.8); ++i) add_anywhere(random_armchair(random_));
    if (options.furnished) {
      for (int i = 0; i < count(0.7); ++i) add_at_wall(random_bed(random_));
      for (int i = 0; i < count(0.7); ++i) add_at_wall(random_sofa(random_));
      for (int i = 0; i < count(0.8); ++i) add_desk();
      for (int i = 0; i < count(0.8); ++i) add_anywhere(random_floor_lamp(random_));
      for (int i = 0; i < count(1); ++i) add_anywhere(random_stool(random_));
    }
    place_small_objects(static_cast<std::uint32_t>(std::floor(options.objects * rooms + 0.5)));
    for (int i = 0; i < std::max(12, count(30)); ++i) add_view();
    scene_.half_x = half_x_;
    scene_.half_y = half_y_;
    scene_.lamp = {0.3, -0.25, 2.6 * std::max(1.0, options.size)};
  }
  RoomScene take() { return std::move(scene_); }

 private:
  /// A shelf in the room, and a measure of its area.
  struct Surface {
    Shelf shelf;
    double area;
  };

  void add_slab(const Vec3& low, const Vec3& high, const Texture& texture, std::uint32_t label) {
    scene_.world.push_back(box_between(low, high, texture, label));
  }

  void add_shell() {
    Texture floor = random_texture(TextureKind::kWood, random_);
    const double light = random_.uniform(0.7, 1.3);
    floor.base = light * Vec3{0.55, 0.4, 0.27};
    floor.second = 0.75 * floor.base;
    floor.scale = 0.04;
    Texture wall = random_texture(TextureKind::kPlain, random_);
    const double tint = random_.uniform(0.78, 0.92);
    wall.base = {tint, tint * random_.uniform(0.96, 1.0), tint * random_.uniform(0.86, 1.0)};
    Texture accent = wall;
    accent.base = lerp(wall.base, random_color(random_), 0.5);
    const double x = half_x_, y = half_y_, t = 0.1, h = kWallHeight;
    add_slab({-x, -y, -t}, {x, y, 0}, floor, 1);
    add_slab({-x, y, 0}, {x, y + t, h}, accent, 2);
    add_slab({x, -y, 0}, {x + t, y, h}, wall, 3);
    add_slab({-x, -y - t, 0}, {x, -y, h}, wall, 4);
    add_slab({-x - t, -y, 0}, {-x, y, h}, wall, 5);
  }

  /// Adds a piece of furniture. Returns false if it would hit something else, or reach through a wall.
  bool add(const Furniture& furniture, const Pose& pose, double gap) {
    const double turns = math::atan2(pose.x.y, pose.x.x) / (2 * kPi);
    const HouseholdObject& body = furniture.body;
    const double reach_x = std::abs(pose.x.x) * body.half_x + std::abs(pose.y.x) * body.half_y;
    const double reach_y = std::abs(pose.x.y) * body.half_x + std::abs(pose.y.y) * body.half_y;
    if (std::abs(pose.origin.x) + reach_x > half_x_ - 0.005) return false;
    if (std::abs(pose.origin.y) + reach_y > half_y_ - 0.005) return false;
    const Arrangement::Footprint box{pose.origin.x, pose.origin.y, turns, body.half_x, body.half_y, 0, body.height};
    if (!floor_plan_.is_free(box, gap)) return false;
    floor_plan_.occupy(box);
    for (const Solid& part : body.parts) {
      scene_.world.push_back({part.shape, pose * part.pose, part.texture, label_});
    }
    for (Shelf shelf : furniture.shelves) {
      shelf.pose = pose * shelf.pose;
      surfaces_.push_back({shelf, shelf.half_x * shelf.half_y});
    }
    label_ += 10;
    return true;
  }

  bool add_freely(const Furniture& furniture, double turns) {
    for (int i = 0; i < 60; ++i) {
      const double x = random_.uniform(-half_x_, half_x_);
      const double y = random_.uniform(-half_y_, half_y_);
      if (add(furniture, rotated(turns, {x, y, 0}), 0.12)) return true;
    }
    return false;
  }

  void add_anywhere(const Furniture& furniture) {
    const double turns = random_.uniform();
    add_freely(furniture, turns);
  }

  /// Adds a piece of furniture with its back to one of the four walls. Returns false if there is no place.
  bool add_at_wall(const Furniture& furniture) {
    constexpr double kBehind = 0.012;
    for (int i = 0; i < 40; ++i) {
      const std::uint32_t wall = random_.below(4);
      const bool along_x = wall % 2 == 0;
      const double place = random_.uniform(-1, 1) * ((along_x ? half_x_ : half_y_) - furniture.body.half_x - 0.01);
      const double away = (along_x ? half_y_ : half_x_) - furniture.body.half_y - kBehind;
      const Vec3 origin = wall == 0   ? Vec3{place, -away, 0}
                          : wall == 1 ? Vec3{away, place, 0}
                          : wall == 2 ? Vec3{place, away, 0}
                                      : Vec3{-away, place, 0};
      if (add(furniture, rotated(wall / 4.0, origin), 0.03)) return true;
    }
    return false;
  }

  /// Adds a desk at a wall and an office chair in front of it.
  void add_desk() {
    const Furniture desk = random_desk(random_);
    const Furniture chair = random_office_chair(random_);
    const double along = random_.uniform(-0.3, 0.1), out = random_.uniform(0.03, 0.25),
                 askew = random_.uniform(-0.1, 0.1);
    if (!add_at_wall(desk)) return;
    const Arrangement::Footprint box = floor_plan_.occupied().back();
    const Pose pose = rotated(box.turns, {box.x, box.y, 0});
    add(chair, pose * rotated(0.5 + askew, {along, box.half_y + 0.36 + out, 0}), 0.01);
  }

  /// Adds a table with chairs around it, each turned a little, as people leave them.
  void add_table_group() {
    const Furniture table = random_table(random_);
    const Furniture chair = random_chair(random_);
    const double askew = random_.uniform(-0.03, 0.03);
    const double quarter = 0.25 * random_.below(2);
    if (!add_freely(table, askew + quarter)) return;
    const Arrangement::Footprint box = floor_plan_.occupied().back();
    const Pose pose = rotated(box.turns, {box.x, box.y, 0});
    for (const double side : {-1.0, 1.0}) {
      for (const double place : {-0.5, 0.5}) {
        const double along = place * box.half_x, out = side * (box.half_y + random_.uniform(0.27, 0.4));
        const double turns = (side < 0 ? 0.0 : 0.5) + random_.uniform(-0.06, 0.06);
        if (random_.chance(0.8)) add(chair, pose * rotated(turns, {along, out, 0}), 0.02);
      }
    }
  }

  void place_small_objects(std::uint32_t count) {
    if (surfaces_.empty()) return;
    double area = 0;
    for (const Surface& surface : surfaces_) area += surface.area;
    for (std::uint32_t i = 0; i < count; ++i) {
      double choice = random_.uniform() * area;
      std::size_t k = 0;
      while (k + 1 < surfaces_.size() && choice >= surfaces_[k].area) choice -= surfaces_[k++].area;
      label_ = place_objects(1, surfaces_[k].shelf, {0.01, 0}, label_, random_, small_, scene_.world);
    }
  }

  bool inside_something(const Vec3& p) const {
    constexpr double kClearance = 0.25;  // meters between a camera and the furniture
    return !floor_plan_.is_free({p.x, p.y, 0, 0.01, 0.01, p.z - kClearance, p.z}, kClearance);
  }

  /// Adds a view as of a person who carries the camera: mostly towards furniture, sometimes in any direction.
  void add_view() {
    Vec3 from;
    do {
      from = {random_.uniform(-0.85, 0.85) * half_x_, random_.uniform(-0.85, 0.85) * half_y_,
              random_.uniform(1.0, 1.9)};
    } while (inside_something(from));
    const double turns = random_.uniform();
    Vec3 to = from + Vec3{math::cos(2 * kPi * turns), math::sin(2 * kPi * turns), random_.uniform(-0.9, 0.15)};
    const auto& things = floor_plan_.occupied();
    if (random_.chance(0.55) && !things.empty()) {
      const auto& thing = things[random_.below(static_cast<std::uint32_t>(things.size()))];
      const double height = random_.uniform(0.2, 1.0) * thing.top;
      const Vec3 target{thing.x, thing.y, height};
      if (norm(target - from) > 0.8 && norm(target - from) < 3.5) to = target;
    }
    scene_.views.push_back(look_at(from, to, 525, 640, 480));
  }

  Random random_;
  double half_x_, half_y_;
  RoomScene scene_;
  Arrangement floor_plan_, small_;
  std::vector<Surface> surfaces_;
  std::uint32_t label_ = 20;
};

}  // namespace

RoomScene arrange_room(const RoomOptions& options) { return RoomBuilder(options).take(); }

void add_ceiling(RoomScene& room) {
  const Texture paint{.kind = TextureKind::kPlain, .base = {0.9, 0.9, 0.88}};
  room.world.push_back(
      box_between({-room.half_x, -room.half_y, kWallHeight}, {room.half_x, room.half_y, kWallHeight + 0.1}, paint, 6));
}

}  // namespace segserve::synth
