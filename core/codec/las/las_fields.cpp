// SPDX-License-Identifier: Apache-2.0
#include "core/codec/las/las_fields.hpp"

#include <array>

namespace segserve::codec {
namespace {

constexpr double kDegreesPerUnit = 0.006;

/// Point formats 0 to 5.
constexpr std::array<LasField, 10> kOldFields{{
    {"intensity", ScalarType::kUint16, 12},
    {"return_number", ScalarType::kUint8, 14, 0, 3},
    {"number_of_returns", ScalarType::kUint8, 14, 3, 3},
    {"scan_direction", ScalarType::kUint8, 14, 6, 1},
    {"edge_of_flight_line", ScalarType::kUint8, 14, 7, 1},
    {"classification", ScalarType::kUint8, 15, 0, 5},
    {"classification_flags", ScalarType::kUint8, 15, 5, 3},
    {"scan_angle", ScalarType::kInt8, 16},
    {"user_data", ScalarType::kUint8, 17},
    {"point_source_id", ScalarType::kUint16, 18},
}};

/// Point formats 6 to 10.
constexpr std::array<LasField, 11> kNewFields{{
    {"intensity", ScalarType::kUint16, 12},
    {"return_number", ScalarType::kUint8, 14, 0, 4},
    {"number_of_returns", ScalarType::kUint8, 14, 4, 4},
    {"classification_flags", ScalarType::kUint8, 15, 0, 4},
    {"scanner_channel", ScalarType::kUint8, 15, 4, 2},
    {"scan_direction", ScalarType::kUint8, 15, 6, 1},
    {"edge_of_flight_line", ScalarType::kUint8, 15, 7, 1},
    {"classification", ScalarType::kUint8, 16},
    {"user_data", ScalarType::kUint8, 17},
    {"scan_angle", ScalarType::kInt16, 18, 0, 0, kDegreesPerUnit},
    {"point_source_id", ScalarType::kUint16, 20},
}};

}  // namespace

LasLayout las_layout(unsigned format) {
  const std::array<LasLayout, kMostLasFormat + 1> layouts{{
      {20, kOldFields, {}, {}, {}, false},
      {28, kOldFields, {}, 20, {}, false},
      {26, kOldFields, 20, {}, {}, false},
      {34, kOldFields, 28, 20, {}, false},
      {57, kOldFields, {}, 20, {}, true},
      {63, kOldFields, 28, 20, {}, true},
      {30, kNewFields, {}, 22, {}, false},
      {36, kNewFields, 30, 22, {}, false},
      {38, kNewFields, 30, 22, 36, false},
      {59, kNewFields, {}, 22, {}, true},
      {67, kNewFields, 30, 22, 36, true},
  }};
  return layouts[format];
}

}  // namespace segserve::codec
