// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/cloud_message.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/base/status_macros.hpp"
#include "fmt/format.h"
#include "proto/wire/codec_message.hpp"
#include "proto/wire/payload/payload_codecs.hpp"
#include "proto/wire/payload/payload_support.hpp"
#include "proto/wire/status_message.hpp"
#include "segserve/codec/unit_conversion.hpp"

namespace segserve::wire {
namespace {

struct UnitNumber {
  codec::LengthUnit unit;
  v1::LengthUnit number;
};

constexpr std::array<UnitNumber, 6> kUnits{{
    {codec::LengthUnit::kMeter, v1::LENGTH_UNIT_METER},
    {codec::LengthUnit::kCentimeter, v1::LENGTH_UNIT_CENTIMETER},
    {codec::LengthUnit::kMillimeter, v1::LENGTH_UNIT_MILLIMETER},
    {codec::LengthUnit::kInch, v1::LENGTH_UNIT_INCH},
    {codec::LengthUnit::kFoot, v1::LENGTH_UNIT_FOOT},
    {codec::LengthUnit::kAuto, v1::LENGTH_UNIT_AUTO},
}};

v1::Position position_message(const Eigen::Vector3f& position) {
  v1::Position message;
  message.set_x(position.x());
  message.set_y(position.y());
  message.set_z(position.z());
  return message;
}

/// Adds what is wrong with the cameras of a view that is WORLD but for that.
std::vector<CameraPoints> read_cameras(const v1::View& message, std::vector<FieldViolation>& faults) {
  std::vector<CameraPoints> cameras;
  if (static_cast<std::size_t>(message.cameras_size()) > kMostCameras) {
    faults.push_back({"cloud.view.cameras", fmt::format("there are {} cameras, but at most {} are possible",
                                                        message.cameras_size(), kMostCameras)});
    return cameras;
  }
  cameras.reserve(static_cast<std::size_t>(message.cameras_size()));
  for (const v1::CameraPoints& camera : message.cameras()) {
    if (!camera.has_sensor()) {
      faults.push_back({fmt::format("cloud.view.cameras[{}].sensor", cameras.size()), "is missing"});
    }
    const v1::Position& sensor = camera.sensor();
    cameras.push_back({camera.points(), {sensor.x(), sensor.y(), sensor.z()}});
  }
  if (auto fault = fault_of_cameras(View::of_cameras(cameras))) {
    faults.push_back({"cloud.view.cameras", std::move(*fault)});
  }
  return cameras;
}

}  // namespace

v1::View to_message(const View& view) {
  v1::View message;
  message.set_kind(view.kind == ViewKind::kCamera ? v1::VIEW_KIND_CAMERA : v1::VIEW_KIND_WORLD);
  if (view.sensor) *message.mutable_sensor() = position_message(*view.sensor);
  for (const CameraPoints& camera : view.cameras) {
    v1::CameraPoints& added = *message.add_cameras();
    added.set_points(camera.points);
    *added.mutable_sensor() = position_message(camera.sensor);
  }
  return message;
}

v1::LengthUnit to_message(codec::LengthUnit unit) { return std::ranges::find(kUnits, unit, &UnitNumber::unit)->number; }

std::optional<codec::LengthUnit> from_message(v1::LengthUnit message) {
  if (message == v1::LENGTH_UNIT_UNSPECIFIED) return codec::LengthUnit::kMeter;
  const auto* const found = std::ranges::find(kUnits, message, &UnitNumber::number);
  return found == kUnits.end() ? std::nullopt : std::optional(found->unit);
}

std::optional<View> from_message(const v1::View& message, std::vector<FieldViolation>& faults) {
  const v1::Position& sensor = message.sensor();
  if (message.cameras_size() > 0) {
    if (message.kind() != v1::VIEW_KIND_WORLD) {
      faults.push_back({"cloud.view.cameras", "are given, but only a WORLD view may have cameras"});
    } else if (message.has_sensor()) {
      faults.push_back({"cloud.view.cameras", "are given, but so is cloud.view.sensor"});
    } else {
      return View::of_cameras(read_cameras(message, faults));
    }
  }
  switch (message.kind()) {
    case v1::VIEW_KIND_UNSPECIFIED:
      if (message.has_sensor()) faults.push_back({"cloud.view.kind", "is missing, but cloud.view.sensor is given"});
      return std::nullopt;
    case v1::VIEW_KIND_CAMERA:
      if (message.has_sensor()) {
        faults.push_back({"cloud.view.sensor", "is given, but a CAMERA view has its sensor at the origin"});
      }
      return View::camera();
    case v1::VIEW_KIND_WORLD:
      if (!message.has_sensor()) return View::world();
      if (!std::isfinite(sensor.x()) || !std::isfinite(sensor.y()) || !std::isfinite(sensor.z())) {
        faults.push_back(
            {"cloud.view.sensor", fmt::format("({}, {}, {}) is not finite", sensor.x(), sensor.y(), sensor.z())});
      }
      return View::world(sensor.x(), sensor.y(), sensor.z());
    default:
      faults.push_back({"cloud.view.kind", fmt::format("{} is not a kind of view", static_cast<int>(message.kind()))});
      return std::nullopt;
  }
}

namespace {

/// The fields around a payload that it needs.
struct PayloadNeeds {
  const char* name;  ///< what messages call the payload; empty if it needs nothing
  bool shape;
  bool view;
};

std::optional<PayloadNeeds> needs_of(v1::Cloud::PayloadCase payload) {
  switch (payload) {
    case v1::Cloud::kPlanar:
      return PayloadNeeds{"a planar cloud", true, true};
    case v1::Cloud::kStrided:
      return PayloadNeeds{"a strided cloud", true, true};
    case v1::Cloud::kQuantised:
      return PayloadNeeds{"a quantised cloud", false, true};
    case v1::Cloud::kDraco:
      return PayloadNeeds{"a Draco cloud", true, true};
    case v1::Cloud::kPcdFile:
    case v1::Cloud::kRgbd:
      return PayloadNeeds{"", false, false};
    case v1::Cloud::PAYLOAD_NOT_SET:
      break;
  }
  return std::nullopt;
}

void check_error_bound(const v1::Cloud& message, std::vector<FieldViolation>& faults) {
  const double bound = message.error_bound();
  if (!std::isfinite(bound) || bound < 0) {
    faults.push_back({"cloud.error_bound", fmt::format("{} is not a finite number of meters", bound)});
  } else if (message.has_quantised() && bound == 0) {
    faults.push_back({"cloud.error_bound", "is missing, but a quantised cloud must declare it"});
  }
}

/// The view that the message gives; nullopt if it gives none. Appends all faults of the fields around the payload.
std::optional<View> read_fields(const v1::Cloud& message, std::vector<FieldViolation>& faults) {
  std::optional<View> view = from_message(message.view(), faults);
  const std::optional<PayloadNeeds> needs = needs_of(message.payload_case());
  if (!needs) {
    faults.push_back({"cloud.payload", "is missing, or of a kind that this server does not know"});
    return view;
  }
  if (needs->view && !view && faults.empty()) {
    faults.push_back(
        {"cloud.view", fmt::format("is missing, but {} needs VIEW_KIND_CAMERA or VIEW_KIND_WORLD", needs->name)});
  }
  if (message.has_rgbd() && view && *view != View::camera()) {
    faults.push_back({"cloud.view.kind", "must be VIEW_KIND_CAMERA for RGB-D images"});
  }
  if (needs->shape && message.width() == 0) {
    faults.push_back({"cloud.width", fmt::format("is 0, but {} needs at least one point", needs->name)});
  }
  if (needs->shape && message.height() == 0) {
    faults.push_back({"cloud.height", fmt::format("is 0, but {} needs at least one row", needs->name)});
  }
  const std::uint64_t points = std::uint64_t{message.width()} * message.height();
  if (view && points > 0 && faults.empty()) {
    if (auto fault = fault_of_cameras(*view, points)) faults.push_back({"cloud.view.cameras", std::move(*fault)});
  }
  if (message.has_rgbd() && message.unit() != v1::LENGTH_UNIT_UNSPECIFIED) {
    faults.push_back({"cloud.unit", "is given, but RGB-D images have a depth_scale instead"});
  } else if (!from_message(message.unit())) {
    faults.push_back({"cloud.unit", fmt::format("{} is not a unit", static_cast<int>(message.unit()))});
  }
  check_error_bound(message, faults);
  return view;
}

/// The cloud, unless the cameras of its view have another number of points. Payloads with a shape of their own tell it
/// only now.
absl::StatusOr<DecodedCloud> with_checked_cameras(absl::StatusOr<DecodedCloud> decoded) {
  if (!decoded.ok()) return decoded;
  const CloudView& cloud = decoded->cloud;
  if (auto fault = fault_of_cameras(cloud.view, cloud.size())) {
    return invalid_fields({{"cloud.view.cameras", std::move(*fault)}});
  }
  return decoded;
}

/// The cloud in meters.
absl::StatusOr<DecodedCloud> convert(absl::StatusOr<DecodedCloud> decoded, codec::LengthUnit unit,
                                     const StopToken& stop) {
  if (!decoded.ok() || unit == codec::LengthUnit::kMeter) return decoded;
  const CloudView& cloud = decoded->cloud;
  ASSIGN_OR_RETURN(auto converted, codec::to_meters(cloud, {.view = cloud.view, .unit = unit}, stop));
  converted.view_rule = std::move(decoded->view_rule);
  return decoded_cloud(std::move(converted));
}

}  // namespace

std::vector<FieldViolation> violations(const v1::Cloud& message) {
  std::vector<FieldViolation> faults;
  read_fields(message, faults);
  return faults;
}

namespace {

absl::StatusOr<DecodedCloud> decode_payload(const v1::Cloud& message, const std::optional<View>& view,
                                            const codec::DecodeLimits& limits, const StopToken& stop) {
  const codec::LengthUnit unit = *from_message(message.unit());
  codec::ReadOptions read{.view = view, .unit = unit};
  if (message.unit() == v1::LENGTH_UNIT_UNSPECIFIED) read.unit.reset();  // The names of the fields may tell it.
  switch (message.payload_case()) {
    case v1::Cloud::kPlanar:
      return convert(decode_planar(message, view, limits, stop), unit, stop);
    case v1::Cloud::kPcdFile:
      return decode_pcd_file(message, read, limits, stop);
    case v1::Cloud::kStrided:
      return decode_strided(message, read, limits, stop);
    case v1::Cloud::kQuantised:
      return convert(decode_quantised(message, view, limits, stop), unit, stop);
    case v1::Cloud::kRgbd:
      return decode_rgbd(message, view, limits, stop);
    case v1::Cloud::kDraco:
      return convert(decode_draco(message, view, limits, stop), unit, stop);
    case v1::Cloud::PAYLOAD_NOT_SET:
      break;  // read_fields has refused it.
  }
  return absl::InternalError("the cloud has no payload");
}

}  // namespace

absl::StatusOr<DecodedCloud> decode_cloud(const v1::Cloud& message, const codec::DecodeLimits& limits,
                                          const StopToken& stop) {
  std::vector<FieldViolation> faults;
  const std::optional<View> view = read_fields(message, faults);
  RETURN_IF_ERROR(invalid_fields(faults));
  RETURN_IF_ERROR(check_kind(message, limits));
  return with_checked_cameras(decode_payload(message, view, limits, stop));
}

}  // namespace segserve::wire
