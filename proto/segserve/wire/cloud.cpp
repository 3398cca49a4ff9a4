#include "segserve/wire/cloud.hpp"

#include <cmath>

#include "fmt/format.h"
#include "segserve/wire/payload/payload.hpp"
#include "segserve/wire/status.hpp"

namespace segserve::wire {
v1alpha1::View to_message(const View& view) {
  v1alpha1::View message;
  message.set_kind(view.kind == ViewKind::kCamera ? v1alpha1::VIEW_KIND_CAMERA : v1alpha1::VIEW_KIND_WORLD);
  if (view.sensor) {
    message.mutable_sensor()->set_x((*view.sensor)[0]);
    message.mutable_sensor()->set_y((*view.sensor)[1]);
    message.mutable_sensor()->set_z((*view.sensor)[2]);
  }
  return message;
}

std::optional<View> from_message(const v1alpha1::View& message, std::vector<FieldViolation>& faults) {
  const v1alpha1::Position& sensor = message.sensor();
  switch (message.kind()) {
    case v1alpha1::VIEW_KIND_UNSPECIFIED:
      if (message.has_sensor()) faults.push_back({"cloud.view.kind", "missing, though cloud.view.sensor is given"});
      return std::nullopt;
    case v1alpha1::VIEW_KIND_CAMERA:
      if (message.has_sensor()) {
        faults.push_back({"cloud.view.sensor", "given, but a CAMERA view has its sensor at the origin"});
      }
      return View::camera();
    case v1alpha1::VIEW_KIND_WORLD:
      if (!message.has_sensor()) return View::world();
      if (!std::isfinite(sensor.x()) || !std::isfinite(sensor.y()) || !std::isfinite(sensor.z())) {
        faults.push_back(
            {"cloud.view.sensor", fmt::format("({}, {}, {}) is not finite", sensor.x(), sensor.y(), sensor.z())});
      }
      return View::world(sensor.x(), sensor.y(), sensor.z());
    default:
      faults.push_back({"cloud.view.kind", fmt::format("{} is no kind of view", static_cast<int>(message.kind()))});
      return std::nullopt;
  }
}

std::vector<FieldViolation> violations(const v1alpha1::Cloud& message) {
  std::vector<FieldViolation> faults;
  const bool has_view = from_message(message.view(), faults).has_value();
  switch (message.payload_case()) {
    case v1alpha1::Cloud::kPlanar:
      if (!has_view && faults.empty()) {
        faults.push_back({"cloud.view", "missing: a planar cloud needs VIEW_KIND_CAMERA or VIEW_KIND_WORLD"});
      }
      if (message.width() == 0) faults.push_back({"cloud.width", "0: a planar cloud needs at least one point"});
      if (message.height() == 0) faults.push_back({"cloud.height", "0: a planar cloud needs at least one row"});
      break;
    case v1alpha1::Cloud::kPcdFile:
      break;
    default:
      faults.push_back({"cloud.payload", "missing or of a kind that this server does not know"});
      break;
  }
  return faults;
}

absl::StatusOr<DecodedCloud> decode_cloud(const v1alpha1::Cloud& message, const codec::DecodeLimits& limits) {
  if (const absl::Status status = invalid_fields(violations(message)); !status.ok()) return status;
  std::vector<FieldViolation> faults;  // none: see above
  const std::optional<View> view = from_message(message.view(), faults);
  if (message.has_planar()) return decode_planar(message, view, limits);
  return decode_pcd_file(message, view, limits);
}

}  // namespace segserve::wire
