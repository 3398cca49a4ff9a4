#include "core/lab/synth/arrangement.hpp"

#include <array>
#include <cmath>
#include <optional>

namespace segserve::synth {
namespace {

using Footprint = Arrangement::Footprint;

struct Rectangle {
  Vec3 center, x, y;  // z = 0; x and y are the half edges
};

Rectangle rectangle(const Footprint& f) {
  const Pose pose = turned(f.turns, {f.x, f.y, 0});
  return {pose.origin, f.half_x * pose.x, f.half_y * pose.y};
}

// Separating axes of two rectangles: apart if their shadows on any edge direction are.
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

// An object that others can stand on.
struct Base {
  Pose pose;  // centre of its top
  double half_x, half_y;
};

constexpr int kTriesPerObject = 40;
constexpr int kModels = 12;  // objects that are tried before a place is given up
constexpr double kStackGap = 0.004;

class Putter {
 public:
  Putter(const Shelf& shelf, const Habits& habits, Random& random, Arrangement& arrangement, World& world)
      : shelf_(shelf), habits_(habits), random_(random), arrangement_(arrangement), world_(world) {}

  bool put_one(std::uint32_t label) {
    const bool on_top = random_.chance(habits_.stacked) && !bases_.empty();
    for (int model = 0; model < kModels; ++model) {
      const Household object = random_household(random_);
      for (int i = 0; i < kTriesPerObject; ++i) {
        const auto pose = on_top ? pose_on_top(object) : pose_on_shelf(object);
        if (pose && place(object, *pose, on_top ? kStackGap : habits_.gap, label)) return true;
      }
    }
    return false;
  }

 private:
  std::optional<Pose> pose_on_shelf(const Household& object) {
    const double turns = random_.uniform();
    const Pose local = turned(turns, {});
    const double reach_x = std::abs(local.x.x) * object.half_x + std::abs(local.y.x) * object.half_y;
    const double reach_y = std::abs(local.x.y) * object.half_x + std::abs(local.y.y) * object.half_y;
    const double free_x = shelf_.half_x - reach_x;
    const double free_y = shelf_.half_y - reach_y;
    const double x = random_.uniform(-1, 1);
    const double y = random_.uniform(-1, 1);
    if (free_x < 0 || free_y < 0 || object.height > shelf_.clearance) return std::nullopt;
    return shelf_.pose * turned(turns, {free_x * x, free_y * y, 0});
  }

  // Its centre is well over the base, so that it would not tip over; it may jut out.
  std::optional<Pose> pose_on_top(const Household& object) {
    const Base& base = bases_[random_.below(static_cast<std::uint32_t>(bases_.size()))];
    const double turns = random_.chance(0.5) ? random_.uniform(-0.06, 0.06) : random_.uniform();
    const double x = random_.uniform(-0.4, 0.4);
    const double y = random_.uniform(-0.4, 0.4);
    const double smaller = object.half_x < object.half_y ? object.half_x : object.half_y;
    const double larger = object.half_x < object.half_y ? object.half_y : object.half_x;
    const double base_smaller = base.half_x < base.half_y ? base.half_x : base.half_y;
    const double base_larger = base.half_x < base.half_y ? base.half_y : base.half_x;
    if (smaller > 1.15 * base_smaller || larger > 1.3 * base_larger) return std::nullopt;
    return base.pose * turned(turns, {x * base.half_x, y * base.half_y, 0});
  }

  bool place(const Household& object, const Pose& pose, double gap, std::uint32_t label) {
    const double turns = math::atan2(pose.x.y, pose.x.x) / (2 * kPi);
    const double bottom = pose.origin.z;
    const Footprint footprint{pose.origin.x, pose.origin.y,         turns, object.half_x, object.half_y,
                              bottom,        bottom + object.height};
    if (footprint.top > shelf_.pose.origin.z + shelf_.clearance || !arrangement_.free(footprint, gap)) return false;
    arrangement_.occupy(footprint);
    for (const Solid& part : object.parts) world_.push_back({part.shape, pose * part.pose, part.texture, label});
    if (object.top_x > 0) {
      bases_.push_back({pose * at({0, 0, object.height}), object.top_x, object.top_y});
    }
    return true;
  }

  const Shelf& shelf_;
  const Habits& habits_;
  Random& random_;
  Arrangement& arrangement_;
  World& world_;
  std::vector<Base> bases_;
};

}  // namespace

bool Arrangement::free(const Footprint& footprint, double gap) const {
  constexpr double kTouching = 1e-9;  // what stands on another touches it
  const Rectangle mine = rectangle(footprint);
  for (const Footprint& other : taken_) {
    if (footprint.bottom > other.top - kTouching || other.bottom > footprint.top - kTouching) continue;
    if (!apart(mine, rectangle(other), gap)) return false;
  }
  return true;
}

std::uint32_t put_objects(std::uint32_t count, const Shelf& shelf, const Habits& habits, std::uint32_t label,
                          Random& random, Arrangement& arrangement, World& world) {
  Putter putter(shelf, habits, random, arrangement, world);
  for (std::uint32_t i = 0; i < count; ++i) {
    if (putter.put_one(label)) label += 10;
  }
  return label;
}

}  // namespace segserve::synth
