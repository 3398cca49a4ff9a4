// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "segserve/cloud.hpp"
#include "segserve/codec/attribute.hpp"
#include "segserve/codec/length_unit.hpp"
#include "segserve/codec/placement.hpp"
#include "segserve/codec/warning.hpp"

namespace segserve::codec {

/// The coordinates of N points as a file has them: x, y and z.
using FilePosition = std::array<std::vector<double>, 3>;

/// Where a sensor was, in the coordinates and the unit of a file, and how it was turned. The rotation
/// is kept and not used: the points of a file have the axes that it says, however its sensor was turned.
struct SensorPose {
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();

  bool is_turned() const { return !rotation.vec().isZero(0); }
};

/// A record of a LAS file that describes its coordinate reference system: a variable length record of user
/// LASF_Projection, by its number, with its payload as it is in the file.
struct ReferenceRecord {
  std::uint16_t id = 0;
  std::string payload;
};

/// The content of a file: a cloud of N points, and the labels if the file has some.
struct LabeledCloud {
  Cloud cloud;                       ///< in meters, near the origin: see `placement`
  std::vector<std::uint32_t> label;  ///< N: the label of each point; empty if the file has no labels
  std::string view_rule;             ///< one line for people that tells which view was chosen, and why
  std::vector<Warning> warnings;     ///< what of the file was not used
  Placement placement;               ///< from the file's coordinates to those of the cloud
  /// The coordinates of the file, if they were asked for and are not those of the cloud bit for bit; else empty.
  FilePosition file_position;
  std::vector<Attribute> attributes;  ///< the other values of the points, if they were asked for
  /// The attribute gps_time is GPS time minus 1e9 s, as LAS may say, and no time of the week.
  bool has_standard_gps_time = false;
  std::optional<SensorPose> viewpoint;  ///< VIEWPOINT of a PCD file, unless it is missing or all default
  /// The coordinate reference system, if everything was asked for. It goes into LAS files again.
  std::vector<ReferenceRecord> reference_records;
  std::string format;  ///< for people: the format of the file, e.g. "PCD"; set by decode_cloud
};

/// The content of a file that is to be written: N points with their labels and other values. It owns nothing.
struct FileContent {
  CloudView cloud = {};                        ///< the coordinates are those of the file, unless `position` has them
  std::span<const std::uint32_t> label = {};   ///< N, or empty if there are no labels
  std::span<const Attribute> attributes = {};  ///< values of N points each
  const FilePosition* position = nullptr;      ///< the coordinates in the file, or null
  LengthUnit unit = LengthUnit::kMeter;        ///< of the coordinates in the file; not kAuto
  bool has_standard_gps_time = false;          ///< see LabeledCloud
  std::optional<SensorPose> viewpoint = std::nullopt;       ///< see LabeledCloud
  std::span<const ReferenceRecord> reference_records = {};  ///< see LabeledCloud
};

/// A cloud that was read with ReadOptions::keep_everything, with other labels, as it goes into a file again: with the
/// coordinates, their unit, the sensor and the attributes of the file that it came from. The file and the labels must
/// outlive the result.
FileContent content_of(const LabeledCloud& file, std::span<const std::uint32_t> label);

}  // namespace segserve::codec
