// SPDX-License-Identifier: Apache-2.0
#include "segserve/codec/unit_conversion.hpp"

#include <array>

#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
#include "core/codec/common/point_positions.hpp"

namespace segserve::codec {

absl::StatusOr<LabeledCloud> to_meters(const CloudView& cloud, const ReadOptions& options, const StopToken& stop) {
  LabeledCloud out;
  out.cloud.resize(cloud.size(), false);
  out.cloud.rgb.assign(cloud.rgb.begin(), cloud.rgb.end());
  out.cloud.width = cloud.width;
  out.cloud.height = cloud.height;
  const auto column = [](std::span<const float> plane) {
    return Column{std::as_bytes(plane).data(), sizeof(float), ScalarType::kFloat32};
  };
  StopCheck check(stop);
  RETURN_IF_ERROR(read_positions({column(cloud.x), column(cloud.y), column(cloud.z)}, true, {}, options, check, out));
  return out;
}

}  // namespace segserve::codec
