#include "segserve/wire/cloud.hpp"

#include <cmath>
#include <span>
#include <utility>

#include "fmt/format.h"
#include "segserve/codec/pcd.hpp"
#include "segserve/codec/planar.hpp"
#include "segserve/wire/block.hpp"
#include "segserve/wire/status.hpp"

namespace segserve::wire {
namespace {

constexpr std::uint64_t kCoordinateBytes = 4;
constexpr std::uint64_t kColorBytes = 3;

/// What a decoder found: damage, or a limit of v1alpha1.Limits exceeded.
absl::Status decode_error(const absl::Status& status) {
  const std::optional<codec::LimitExcess> excess = codec::limit_excess(status);
  if (!excess) return with_reason(status, v1alpha1::ERROR_REASON_MALFORMED_PAYLOAD);
  return with_details(absl::Status(status.code(), status.message()),
                      {.reason = v1alpha1::ERROR_REASON_LIMIT_EXCEEDED,
                       .metadata = {{"limit", excess->limit == "max_bytes" ? "max_decoded_bytes" : excess->limit},
                                    {"allowed", fmt::format("{}", excess->allowed)},
                                    {"actual", fmt::format("{}", excess->actual)}}});
}

absl::Status check_limits(std::uint64_t points, std::uint64_t bytes, const codec::DecodeLimits& limits) {
  if (points > limits.max_points)
    return limit_exceeded("the cloud has", points, "points", "max_points", limits.max_points);
  if (bytes > limits.max_bytes) {
    return limit_exceeded("the cloud decodes to", bytes, "bytes", "max_decoded_bytes", limits.max_bytes);
  }
  return absl::OkStatus();
}

/// One plane after the other, so that an error names its block.
class PlaneReader {
 public:
  std::string_view read(const v1alpha1::Block& block, std::uint64_t bytes, std::string_view name, std::string& buffer) {
    if (!status_.ok()) return {};
    const absl::StatusOr<std::string_view> plane = block_bytes(block, bytes, name, buffer);
    status_ = plane.status();
    return plane.ok() ? *plane : std::string_view();
  }
  const absl::Status& status() const { return status_; }

 private:
  absl::Status status_;
};

absl::StatusOr<DecodedCloud> decode(const v1alpha1::Cloud& message, const v1alpha1::PlanarCloud& planar,
                                    const View& view, const codec::DecodeLimits& limits) {
  const std::uint64_t points = std::uint64_t{message.width()} * message.height();
  const bool has_color = !planar.rgb().data().empty() || planar.rgb().decoded_bytes() != 0;
  // A point takes at most 15 bytes, so the product cannot overflow once max_points is kept.
  if (const absl::Status status = check_limits(points, 0, limits); !status.ok()) return status;
  const std::uint64_t bytes = points * (3 * kCoordinateBytes + (has_color ? kColorBytes : 0));
  if (const absl::Status status = check_limits(points, bytes, limits); !status.ok()) return status;

  codec::PlanarPlanes buffers;
  codec::PlanarBytes planes;
  PlaneReader reader;
  planes.x = reader.read(planar.x(), kCoordinateBytes * points, "cloud.planar.x", buffers.x);
  planes.y = reader.read(planar.y(), kCoordinateBytes * points, "cloud.planar.y", buffers.y);
  planes.z = reader.read(planar.z(), kCoordinateBytes * points, "cloud.planar.z", buffers.z);
  if (has_color) planes.rgb = reader.read(planar.rgb(), kColorBytes * points, "cloud.planar.rgb", buffers.rgb);
  if (!reader.status().ok()) return reader.status();

  absl::StatusOr<Cloud> cloud = codec::decode_planar(planes, message.width(), message.height(), view, limits);
  if (!cloud.ok()) return decode_error(cloud.status());
  return DecodedCloud{*std::move(cloud),
                      fmt::format("{} as the request says", view.kind == ViewKind::kCamera ? "CAMERA" : "WORLD")};
}

absl::StatusOr<DecodedCloud> decode(const v1alpha1::Cloud& message, const v1alpha1::PcdFile& file,
                                    std::optional<View> view, const codec::DecodeLimits& limits) {
  absl::StatusOr<codec::LabelledCloud> decoded = codec::decode_pcd(std::as_bytes(std::span(file.data())), limits, view);
  if (!decoded.ok()) return decode_error(decoded.status());
  const Cloud& cloud = decoded->cloud;
  const bool shape_is_given = message.width() != 0 || message.height() != 0;
  if (shape_is_given && (message.width() != cloud.width || message.height() != cloud.height)) {
    return invalid_fields({{"cloud.width", fmt::format("{} x {} is said, but the PCD file has {} x {}", message.width(),
                                                       message.height(), cloud.width, cloud.height)}});
  }
  return DecodedCloud{std::move(decoded->cloud), std::move(decoded->view_rule)};
}

}  // namespace

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

absl::StatusOr<v1alpha1::Cloud> to_planar_message(const CloudView& cloud, v1alpha1::Compression compression) {
  codec::PlanarPlanes planes = codec::encode_planar(cloud);
  v1alpha1::Cloud message;
  message.set_width(cloud.width);
  message.set_height(cloud.height);
  *message.mutable_view() = to_message(cloud.view);
  v1alpha1::PlanarCloud* planar = message.mutable_planar();
  const auto put = [compression](std::string& plane, v1alpha1::Block* block) {
    absl::StatusOr<v1alpha1::Block> made = to_block(std::move(plane), compression);
    if (!made.ok()) return made.status();
    *block = *std::move(made);
    return absl::OkStatus();
  };
  absl::Status status = put(planes.x, planar->mutable_x());
  if (status.ok()) status = put(planes.y, planar->mutable_y());
  if (status.ok()) status = put(planes.z, planar->mutable_z());
  if (status.ok() && cloud.has_color()) status = put(planes.rgb, planar->mutable_rgb());
  if (!status.ok()) return status;
  return message;
}

v1alpha1::Cloud to_pcd_message(std::string file_bytes, std::optional<View> view) {
  v1alpha1::Cloud message;
  if (view) *message.mutable_view() = to_message(*view);
  message.mutable_pcd_file()->set_data(std::move(file_bytes));
  return message;
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
    case v1alpha1::Cloud::PAYLOAD_NOT_SET:
      faults.push_back({"cloud.payload", "missing or of a kind that this server does not know"});
      break;
  }
  return faults;
}

absl::StatusOr<DecodedCloud> decode_cloud(const v1alpha1::Cloud& message, const codec::DecodeLimits& limits) {
  if (const absl::Status status = invalid_fields(violations(message)); !status.ok()) return status;
  std::vector<FieldViolation> faults;  // none: see above
  const std::optional<View> view = from_message(message.view(), faults);
  if (message.has_planar()) return decode(message, message.planar(), *view, limits);
  return decode(message, message.pcd_file(), view, limits);
}

}  // namespace segserve::wire
