// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/arrangement.hpp"

#include <array>
#include <cmath>
#include <optional>

namespace segserve::synth {
namespace {

using Footprint = Arrangement::Footprint;

struct Rectangle {
  Vec3 center, x, y;  // x and y are the half edges; all have z = 0.
};

Rectangle rectangle(const Footprint& f) {
  const Pose pose = rotated(f.turns, {f.x, f.y, 0});
  return {pose.origin, f.half_x * pose.x, f.half_y * pose.y};
}

/// True if the rectangles are more than `gap` apart along one of their edge directions (separating axis test).
bool apart(const Rectangle& a, const Rectangle& b, double gap) {
  const Vec3 between = b.center - a.center;
  for (const Vec3& edge : std::array<Vec3, 4>{a.x, a.y, b.x, b.y}) {
    const Vec3 axis = unit(edge);
    const double reach =
        std::abs(dot(axis, a.x)) + std::abs(dot(axis, a.y)) + std::abs(dot(axis, b.x)) + std::abs(dot(axis, b.y));
    if (std::abs(dot(axis, between)) > reach + gap) return true;
  }
  return false;
}

/// The top of an object, on which others can stand.
struct StackTop {
  Pose pose;  // Its origin is the center of the top.
  double half_x, half_y;
};

constexpr int kTriesPerModel = 40;
constexpr int kModels = 12;          // random objects that are tried until one fits
constexpr double kStackGap = 0.004;  // meters

class ObjectPlacer {
 public:
  ObjectPlacer(const Shelf& shelf, const PlacementOptions& options, Random& random, Arrangement& arrangement,
               World& world)
      : shelf_(shelf), options_(options), random_(random), arrangement_(arrangement), world_(world) {}

  /// Returns false if no place was found.
  bool place_one(std::uint32_t label) {
    const bool on_top = random_.chance(options_.stacked) && !stack_tops_.empty();
    for (int model = 0; model < kModels; ++model) {
      const HouseholdObject object = options_.make(random_);
      for (int i = 0; i < kTriesPerModel; ++i) {
        const auto pose = on_top ? pose_on_top(object) : pose_on_shelf(object);
        if (pose && place(object, *pose, on_top ? kStackGap : options_.gap, label)) return true;
      }
    }
    return false;
  }

 private:
  std::optional<Pose> pose_on_shelf(const HouseholdObject& object) {
    const double turns = random_.uniform();
    const Pose local = rotated(turns, {});
    const double reach_x = std::abs(local.x.x) * object.half_x + std::abs(local.y.x) * object.half_y;
    const double reach_y = std::abs(local.x.y) * object.half_x + std::abs(local.y.y) * object.half_y;
    const double free_x = shelf_.half_x - reach_x;
    const double free_y = shelf_.half_y - reach_y;
    const double x = random_.uniform(-1, 1);
    const double y = random_.uniform(-1, 1);
    if (free_x < 0 || free_y < 0 || object.height > shelf_.clearance) return std::nullopt;
    return shelf_.pose * rotated(turns, {free_x * x, free_y * y, 0});
  }

  /// The center of the object is well over the top that it stands on, so that it would not tip over. It may overhang.
  std::optional<Pose> pose_on_top(const HouseholdObject& object) {
    const StackTop& top = stack_tops_[random_.below(static_cast<std::uint32_t>(stack_tops_.size()))];
    const double turns = random_.chance(0.5) ? random_.uniform(-0.06, 0.06) : random_.uniform();
    const double x = random_.uniform(-0.4, 0.4);
    const double y = random_.uniform(-0.4, 0.4);
    const double smaller = object.half_x < object.half_y ? object.half_x : object.half_y;
    const double larger = object.half_x < object.half_y ? object.half_y : object.half_x;
    const double top_smaller = top.half_x < top.half_y ? top.half_x : top.half_y;
    const double top_larger = top.half_x < top.half_y ? top.half_y : top.half_x;
    if (smaller > 1.15 * top_smaller || larger > 1.3 * top_larger) return std::nullopt;
    return top.pose * rotated(turns, {x * top.half_x, y * top.half_y, 0});
  }

  bool place(const HouseholdObject& object, const Pose& pose, double gap, std::uint32_t label) {
    const double turns = math::atan2(pose.x.y, pose.x.x) / (2 * kPi);
    const double bottom = pose.origin.z;
    const Footprint footprint{pose.origin.x, pose.origin.y,         turns, object.half_x, object.half_y,
                              bottom,        bottom + object.height};
    if (footprint.top > shelf_.pose.origin.z + shelf_.clearance || !arrangement_.is_free(footprint, gap)) return false;
    arrangement_.occupy(footprint);
    for (const Solid& part : object.parts) world_.push_back({part.shape, pose * part.pose, part.texture, label});
    if (object.top_x > 0) {
      stack_tops_.push_back({pose * translated({0, 0, object.height}), object.top_x, object.top_y});
    }
    return true;
  }

  const Shelf& shelf_;
  const PlacementOptions& options_;
  Random& random_;
  Arrangement& arrangement_;
  World& world_;
  std::vector<StackTop> stack_tops_;
};

}  // namespace

bool Arrangement::is_free(const Footprint& footprint, double gap) const {
  constexpr double kTouching = 1e-9;  // An object that stands on another touches it.
  const Rectangle mine = rectangle(footprint);
  for (const Footprint& other : occupied_) {
    if (footprint.bottom > other.top - kTouching || other.bottom > footprint.top - kTouching) continue;
    if (!apart(mine, rectangle(other), gap)) return false;
  }
  return true;
}

std::uint32_t place_objects(std::uint32_t count, const Shelf& shelf, const PlacementOptions& options,
                            std::uint32_t label, Random& random, Arrangement& arrangement, World& world) {
  ObjectPlacer placer(shelf, options, random, arrangement, world);
  for (std::uint32_t i = 0; i < count; ++i) {
    if (placer.place_one(label)) label += 10;
  }
  return label;
}

}  // namespace segserve::synth
